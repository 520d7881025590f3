"""The interactive page of a motion for a browser, and the widget of a notebook."""
