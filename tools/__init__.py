"""Maintenance scripts of the workbook; readers of the chapters need none of them."""
