"""What the dashboard shows and what its keys mean. Only `panel` knows Textual; the rest is values in, lines out.

keyboard    keys and time -> stick positions -> RC bytes, with the dead-man's lease
scene       all that one picture shows, in one value
text        lines made of words and roles; numbers that keep their width; bars
canvas      braille dots
layout      which panel stands where, for every size of terminal
view        a scene -> the lines of each panel
panel       lines -> cells of a Textual widget, only those that changed
"""
