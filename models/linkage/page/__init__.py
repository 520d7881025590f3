"""A page that opens in a browser and follows what is dragged."""
