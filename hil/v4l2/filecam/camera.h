/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * filecam: a capture device for tests. Frames written to /dev/filecam_in come out of /dev/videoN octet for octet, whatever
 * the timing: a writer waits until a buffer is queued. Buffer ownership, errors and unplugging are videobuf2's own.
 *
 * feed.c        the side of the light: /dev/filecam_in, and the module's beginning and end
 * connection.c  plugging and unplugging
 * video.c       what the device says of itself: formats, interval, input
 * frames.c      buffers, from queued to filled
 *
 * One camera for the life of the module; each connection is a video device of its own, so that an open descriptor of an
 * unplugged one stays valid until it is closed, as with real hardware.
 */
#ifndef POLHODE_FILECAM_CAMERA_H
#define POLHODE_FILECAM_CAMERA_H

#include <linux/mutex.h>
#include <linux/spinlock.h>
#include <linux/wait.h>
#include <media/v4l2-ctrls.h>
#include <media/v4l2-dev.h>
#include <media/v4l2-device.h>
#include <media/videobuf2-v4l2.h>

#include "feed_format.h"

struct filecam_pixels {
	u32 fourcc;
	u32 octets_per_pixel;
};

/* One connection. Lives until it is unplugged and nobody has it open. */
struct filecam {
	struct v4l2_device v4l2;
	struct video_device video;
	struct v4l2_ctrl_handler controls;
	struct v4l2_ctrl *exposure;
	struct v4l2_ctrl *gain;
	struct vb2_queue queue;
	struct mutex lock;	/* of ioctls and the queue */
	spinlock_t buffers_lock;
	struct list_head buffers;	/* queued and empty, oldest first */
	u32 queued;
	u32 sequence;
	bool streaming;
	bool failed;	/* until the stream is started anew */
	const struct filecam_pixels *pixels;
	u32 width;
	u32 height;
	struct v4l2_fract interval;
	wait_queue_head_t *feed_wait;	/* woken when a frame may be taken */
};

/* frames.c */
int filecam_init_queue(struct filecam *camera, struct device *device);
u32 filecam_image_octets(const struct filecam *camera);
/* Fills the oldest queued buffer from the feeder's memory. -EAGAIN: none is queued. */
int filecam_deliver(struct filecam *camera, const struct filecam_header *header, const char __user *pixels);

/* video.c */
void filecam_set_defaults(struct filecam *camera);
int filecam_register_video(struct filecam *camera, void (*release)(struct video_device *video));

/* connection.c; both with the lock held under which the connection changes */
struct filecam *filecam_connect(struct device *parent, wait_queue_head_t *feed_wait);
/* Stops the stream; the last descriptor's close frees the rest. */
void filecam_disconnect(struct filecam *camera);

#endif
