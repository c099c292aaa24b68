"""The pattern on a surface: courses, staggered joints, wedges."""
