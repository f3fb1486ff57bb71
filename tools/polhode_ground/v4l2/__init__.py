"""The host's side of the virtual machine in hil/v4l2: sequences for its camera, and what its jobs have left."""
