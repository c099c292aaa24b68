"""What answers a wish: the model that it makes, the process that computes, and its tasks."""
