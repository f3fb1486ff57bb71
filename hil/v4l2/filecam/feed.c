// SPDX-License-Identifier: GPL-2.0-only
/* The side of the light: /dev/filecam_in, and the module's beginning and end. */
#include <linux/err.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/uaccess.h>

#include "camera.h"

static struct platform_device *parent;
static struct filecam *camera;	/* the present connection, or NULL */
static DEFINE_MUTEX(feed_lock);	/* one feeder at a time; `camera` changes only under it */
static DEFINE_SPINLOCK(present_lock);	/* and under this, for those who only look whether they should wake up */
static DECLARE_WAIT_QUEUE_HEAD(feed_wait);

static void set_present(struct filecam *present)
{
	spin_lock(&present_lock);
	camera = present;
	spin_unlock(&present_lock);
}

/* With feed_lock held. */
static int connect(void)
{
	struct filecam *plugged;

	if (camera)
		return -EEXIST;
	plugged = filecam_connect(&parent->dev, &feed_wait);
	if (IS_ERR(plugged))
		return PTR_ERR(plugged);
	set_present(plugged);
	return 0;
}

/* With feed_lock held. */
static void disconnect(void)
{
	struct filecam *gone = camera;

	if (!gone)
		return;
	set_present(NULL);
	wake_up(&feed_wait);
	filecam_disconnect(gone);
}

static bool ready_for_frame(void)
{
	bool ready;

	spin_lock(&present_lock);
	ready = camera && camera->streaming && !camera->failed && camera->queued;
	spin_unlock(&present_lock);
	return ready;
}

/* With feed_lock held, but for while it waits. */
static int wait_until_ready(const struct file *file)
{
	int error = 0;

	while (!error && !ready_for_frame()) {
		mutex_unlock(&feed_lock);
		error = file->f_flags & O_NONBLOCK ? -EAGAIN : wait_event_interruptible(feed_wait, ready_for_frame());
		mutex_lock(&feed_lock);
	}
	return error;
}

static int feed_frame(const struct file *file, const struct filecam_header *header, const char __user *pixels)
{
	int error;

	do {	/* again when the stream has been stopped in between */
		error = wait_until_ready(file);
		if (!error)
			error = filecam_deliver(camera, header, pixels);
	} while (error == -EAGAIN && !(file->f_flags & O_NONBLOCK));
	return error;
}

static void fail_stream(void)
{
	if (camera) {
		camera->failed = true;
		vb2_queue_error(&camera->queue);
	}
}

static ssize_t feed_write(struct file *file, const char __user *data, size_t octets, loff_t *position)
{
	struct filecam_header header;
	int error = 0;

	if (octets < sizeof(header) || copy_from_user(&header, data, sizeof(header)))
		return -EINVAL;
	if (header.command == FILECAM_FRAME && octets != sizeof(header) + header.octets)
		return -EINVAL;
	mutex_lock(&feed_lock);
	switch (header.command) {
	case FILECAM_FRAME:
		error = feed_frame(file, &header, data + sizeof(header));
		break;
	case FILECAM_FATAL_ERROR:
		fail_stream();
		break;
	case FILECAM_DISCONNECT:
		disconnect();
		break;
	case FILECAM_CONNECT:
		error = connect();
		break;
	default:
		error = -EINVAL;
	}
	mutex_unlock(&feed_lock);
	return error ? error : octets;
}

static ssize_t feed_read(struct file *file, char __user *data, size_t octets, loff_t *position)
{
	struct filecam_state state = {};

	if (octets < sizeof(state))
		return -EINVAL;
	mutex_lock(&feed_lock);
	if (camera) {
		state = (struct filecam_state){
			.streaming = camera->streaming && !camera->failed,
			.queued = camera->queued,
			.exposure_100us = v4l2_ctrl_g_ctrl(camera->exposure),
			.gain = v4l2_ctrl_g_ctrl(camera->gain),
			.width_px = camera->width,
			.height_px = camera->height,
			.pixel_format = camera->pixels->fourcc,
			.connected = 1,
		};
	}
	mutex_unlock(&feed_lock);
	return copy_to_user(data, &state, sizeof(state)) ? -EFAULT : sizeof(state);
}

static const struct file_operations feed_ops = {
	.owner = THIS_MODULE,
	.write = feed_write,
	.read = feed_read,
};

static struct miscdevice feed_device = {
	.minor = MISC_DYNAMIC_MINOR,
	.name = "filecam_in",
	.fops = &feed_ops,
};

/* Nobody feeds before the device is there, nor after it has gone. */
static int __init filecam_init(void)
{
	int error;

	parent = platform_device_register_simple("filecam", -1, NULL, 0);
	if (IS_ERR(parent))
		return PTR_ERR(parent);
	mutex_lock(&feed_lock);
	error = connect();
	mutex_unlock(&feed_lock);
	if (!error)
		error = misc_register(&feed_device);
	if (error) {
		mutex_lock(&feed_lock);
		disconnect();
		mutex_unlock(&feed_lock);
		platform_device_unregister(parent);
	}
	return error;
}

static void __exit filecam_exit(void)
{
	misc_deregister(&feed_device);
	mutex_lock(&feed_lock);
	disconnect();
	mutex_unlock(&feed_lock);
	platform_device_unregister(parent);
}

module_init(filecam_init);
module_exit(filecam_exit);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("File-fed V4L2 test camera");
