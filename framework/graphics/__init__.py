"""Figures: what is drawn as lines, joint symbols and texts in lengths, and what draws it with matplotlib."""
