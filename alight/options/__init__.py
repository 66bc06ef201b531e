"""Options: one table for Python, the command line, the laboratory and the documentation.

`kinds` say what a value may be, `table` makes fields of them, `entry` makes the keywords of Python
functions of the tables, `alight.cli.words` those of commands.
"""
