// SPDX-License-Identifier: GPL-2.0-only
/* Plugging and unplugging. */
#include <linux/err.h>
#include <linux/slab.h>

#include "camera.h"

/* The feeder reads the values: it plays the sensor. */
static int accept_control(struct v4l2_ctrl *control)
{
	return 0;
}

static const struct v4l2_ctrl_ops control_ops = { .s_ctrl = accept_control };

static int add_controls(struct filecam *c)
{
	v4l2_ctrl_handler_init(&c->controls, 3);
	c->exposure = v4l2_ctrl_new_std(&c->controls, &control_ops, V4L2_CID_EXPOSURE_ABSOLUTE, 1, 10000, 1, 100);
	c->gain = v4l2_ctrl_new_std(&c->controls, &control_ops, V4L2_CID_GAIN, 0, FILECAM_GAIN_MAX, 1, 16);
	v4l2_ctrl_new_std_menu(&c->controls, &control_ops, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, 0,
			       V4L2_EXPOSURE_MANUAL);
	c->v4l2.ctrl_handler = &c->controls;
	return c->controls.error;
}

/* Of the last reference's end: unplugged, and no descriptor open. */
static void release_camera(struct v4l2_device *v4l2)
{
	struct filecam *c = container_of(v4l2, struct filecam, v4l2);

	v4l2_ctrl_handler_free(&c->controls);
	mutex_destroy(&c->lock);
	kfree(c);
}

static void release_video(struct video_device *video)
{
	struct filecam *c = container_of(video, struct filecam, video);

	v4l2_device_put(&c->v4l2);
}

struct filecam *filecam_connect(struct device *parent, wait_queue_head_t *feed_wait)
{
	struct filecam *c = kzalloc(sizeof(*c), GFP_KERNEL);
	int error;

	if (!c)
		return ERR_PTR(-ENOMEM);
	c->feed_wait = feed_wait;
	mutex_init(&c->lock);
	filecam_set_defaults(c);
	strscpy(c->v4l2.name, "filecam", sizeof(c->v4l2.name));
	error = v4l2_device_register(parent, &c->v4l2);
	if (error) {
		kfree(c);
		return ERR_PTR(error);
	}
	c->v4l2.release = release_camera;
	error = add_controls(c);
	if (!error)
		error = filecam_init_queue(c, parent);
	if (!error)
		error = filecam_register_video(c, release_video);
	if (error) {
		v4l2_device_disconnect(&c->v4l2);
		v4l2_device_put(&c->v4l2);
		return ERR_PTR(error);
	}
	return c;
}

void filecam_disconnect(struct filecam *c)
{
	v4l2_device_get(&c->v4l2);
	vb2_video_unregister_device(&c->video);
	v4l2_device_disconnect(&c->v4l2);
	v4l2_device_put(&c->v4l2);
}
