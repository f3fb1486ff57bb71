/* SPDX-License-Identifier: GPL-2.0-only OR MIT */
/* What is written to and read from /dev/filecam_in: the side of the test camera where the light comes in. */
#ifndef POLHODE_FILECAM_FEED_FORMAT_H
#define POLHODE_FILECAM_FEED_FORMAT_H

#include <linux/types.h>

enum filecam_command {
	FILECAM_FRAME = 0,	/* the header is followed by `octets` of pixels */
	FILECAM_FATAL_ERROR = 1,	/* the stream fails until it is started anew */
	FILECAM_DISCONNECT = 2,	/* the device goes away */
	FILECAM_CONNECT = 3,	/* and comes back, with another number perhaps */
};

#define FILECAM_FLAG_DAMAGED 1u	/* the frame is handed over with the error flag */
#define FILECAM_GAIN_MAX 480

struct filecam_header {
	__u32 command;
	__u32 flags;
	__u64 timestamp_ns;	/* 0: now */
	__u32 sequence_skip;	/* frames that the sensor took and lost before this one */
	__u32 octets;
};

struct filecam_state {
	__u32 streaming;
	__u32 queued;	/* buffers that wait for a frame */
	__u32 exposure_100us;
	__u32 gain;
	__u32 width_px;
	__u32 height_px;
	__u32 pixel_format;
	__u32 connected;
};

#endif
