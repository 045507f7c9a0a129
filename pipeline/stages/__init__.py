"""The stages of a run: sections of the configuration to results. ``run`` is the place to begin.

    plate_settings ─ rate (track_cache, live_clip) ──┐
    session_logs ─ poses, recordings ──┬─ triads (references, user_effects)
    context (cache, progress)          ├─ triad_poses                     run: all of them
                                       └─ mounting      rehearsal: the part without clips
"""
