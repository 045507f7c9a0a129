"""Parsers of sensor streams: bytes in, samples out, without a serial port.

Every parser takes bytes in pieces of any size, buffers a bounded part of them, recovers after
damage, counts damaged parts, and never raises, whatever the bytes are.
"""
