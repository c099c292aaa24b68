"""The pattern on a surface: courses, staggered head joints, wedges."""
