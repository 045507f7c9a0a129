"""A recorded session played back as a serial device, to rehearse a recording.

    session ─ device ─ pseudo_port
"""
