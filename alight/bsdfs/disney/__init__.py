"""Disney's models of many lobes: `principled`, and Burley's as Mitsuba has them."""
