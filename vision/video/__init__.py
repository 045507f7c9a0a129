"""A clip as frames with their time stamps, as it is to be shown.

    clip ─ reader ─ batches of Frame
             ├─ orientation   how a file wants its frames turned and mirrored
             ├─ reduction     frames reduced by a whole factor
             └─ av_decoder    another decoder, where OpenCV hands back black frames
"""
