"""The makers, one module per stage: each calls its stage, measures the result, and makes its files and summary.

The code of a stage begins here: what these modules import makes up its fingerprint. They import `Results` for its type
only, since that knows all stages.
"""
