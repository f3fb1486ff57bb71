"""Judging of replay outputs against truth. Frames, units and file formats: the project's interface document.

C is the camera (x right, y down, z forward), T the target's body frame; p_C = R_CT * p_T + p_CT.
"""
