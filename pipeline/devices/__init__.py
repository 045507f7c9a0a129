"""What sensors send: bytes in, samples out, without a serial port in sight.

Every parser takes bytes in pieces of any size, keeps a bounded part of them, finds its way back
after damage, counts what was damaged, and never raises, whatever the bytes are.
"""
