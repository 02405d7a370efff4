"""Commands that measure: against known truth, speed against accuracy, and until it breaks."""
