"""Bodies that hide what is behind them: sorted by depth, lit, and laid over each other from front to back."""
