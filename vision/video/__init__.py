"""A clip as frames with their time stamps, in display orientation.

    clip ─ reader ─ batches of Frame
             ├─ orientation   rotation and mirroring of the frames, as stated by the file
             ├─ reduction     frames reduced by a whole factor
             └─ av_decoder    another decoder, if OpenCV returns black frames
"""
