"""Text output: the live view, plain lines, tables and summaries."""
