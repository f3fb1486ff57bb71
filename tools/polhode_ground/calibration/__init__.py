"""A camera's intrinsics from pictures of a board: boards finds corners, solve fits, diagnose says what is wrong."""
