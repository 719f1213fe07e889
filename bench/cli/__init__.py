"""The command line, a file a verb. Each has `add_arguments(parser)` and `run(args) -> exit status`.

Imports that cost time stand inside `run`; words for people are printed here and nowhere below.
"""
