"""Values to scenes: what a picture shows, before anything is drawn."""
