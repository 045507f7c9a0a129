"""The stages of a run: sections of the configuration to artefacts.

    plate_settings ─ rate (track_cache, live_clip) ──┐
    poses ─────────────────────────┬─ triads (site, user_effects) ─ certificate
    context (cache, progress)      └─ mounting
"""
