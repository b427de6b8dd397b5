"""Parts of the documentation that are read off the program when it is built, so that they cannot be wrong.

A line `<!-- from code: NAME -->` in a page stands for the Markdown that the function of that name in `parts` returns.
"""
