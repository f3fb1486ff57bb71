"""The page of a run: gather reads, words and tables say, figures and frames draw, page.html.jinja sets it."""
