"""Noise of a sensor at rest: Allan deviation, and the coefficients of IEEE Std 952.

    stillness ─ allan ─ spectra ─ coefficients
"""
