"""A file for each kind of port; `serial_port` and `can_port` are what everybody else opens them by."""
