"""``pipeline clock``: the error of a camera's clock, by a hand that turns on a screen.

``page``       draws the hand, at every refresh of the screen by the browser's own clock
``screen``     receives the page's reports and compares the browser's clock with the computer's
``ntp``        compares the computer's clock with that of a time server
``computer``   the operating system's statement on its clock where no server answers
``measure``    the film of the screen, and from it the camera's clock

A browser draws, because every computer has one, its pictures come with the refresh of the screen,
and it reports the time of each. Its clock (``performance.now()``) is not disciplined on most
systems, so it is not trusted, but compared with the computer's and with a time server's during the
film.
"""
