"""The same tests on every machine and every day."""

import signal

from hypothesis import settings

settings.register_profile("same", derandomize=True)
settings.load_profile("same")

# A shell has its background jobs ignore Ctrl-C, and what they start inherits that; there are tests
# that interrupt what they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
