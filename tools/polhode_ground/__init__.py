"""The ground side of Polhode. Commands of tools/ and hil/ call it; so do entry points of the same names (pyproject.toml).

common        environment of a command, errors, files, sequences, tables: what all others use
judge         runs beside the truth and other programs
campaigns     many scenes and settings, and one report
scenes        what Blender draws; runs in Blender's own Python
paths         random flights past boxes
transforms    changed copies of sequences
faults        bit flips and kills of a live run
v4l2          the host's side of the virtual machine
importing, calibration                  what people bring
plots, reporting, watching, exporting   what people see and take away
busgen        everything that follows from config/bus
checking, verification, materials, website   of the project itself
testing       made-up sequences and runs
"""
