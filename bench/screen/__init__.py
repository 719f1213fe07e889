"""What the dashboard shows and what its keys mean. Only `panel` knows Textual; the rest is values in, lines out.

keyboard    keys and ticks -> stick positions -> RC bytes, with the dead-man's lease
session     a person and a bench: keys in, ticks when they are due, a scene out
scene       all that one picture shows, in one value
lamp        a golden, held against the run while it runs
sight       which page, what filter, what the scope shows: keys in, what has to be sampled out
opening     what stands there before there is a bench
layout      which panel stands where, for every page and size of terminal
view        a scene -> the lines of each panel: bars, strip, arena, status, glance, wheels, wires, wiretable, scope,
            checks, pages
text        lines made of words and roles; numbers that keep their width; bars
canvas      braille dots
panel       lines -> cells of a Textual widget, only those that changed
ink         lines -> what a terminal is sent for them, where no toolkit is needed between
"""
