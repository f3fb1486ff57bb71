// SPDX-License-Identifier: GPL-2.0
/*
 * filecam: a capture device for tests. Frames written to /dev/filecam_in come out of /dev/videoN octet for octet, whatever
 * the timing: a writer waits until a buffer is queued. Buffer ownership, errors and unplugging are videobuf2's own.
 *
 * One camera for the life of the module; each connection is a video device of its own, so that an open descriptor of an
 * unplugged one stays valid until it is closed, as with real hardware.
 */
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/slab.h>
#include <linux/uaccess.h>
#include <media/v4l2-ctrls.h>
#include <media/v4l2-dev.h>
#include <media/v4l2-device.h>
#include <media/v4l2-event.h>
#include <media/v4l2-ioctl.h>
#include <media/videobuf2-v4l2.h>
#include <media/videobuf2-vmalloc.h>

#include "feed_format.h"

#define SIDE_MIN 16u
#define WIDTH_MAX 4096u
#define HEIGHT_MAX 3072u

struct format {
	u32 fourcc;
	u32 octets_per_pixel;
};

static const struct format formats[] = {
	{ V4L2_PIX_FMT_GREY, 1 },
	{ V4L2_PIX_FMT_Y10, 2 },
	{ V4L2_PIX_FMT_Y12, 2 },
	{ V4L2_PIX_FMT_Y16, 2 },
};

struct frame_buffer {
	struct vb2_v4l2_buffer vb;	/* first: vb2 allocates the whole */
	struct list_head list;
};

/* One connection. Lives until it is unplugged and nobody has it open. */
struct camera {
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
	const struct format *format;
	u32 width;
	u32 height;
	struct v4l2_fract interval;
};

static struct platform_device *parent;
static struct camera *camera;	/* the present connection, or NULL */
static DEFINE_MUTEX(feed_lock);	/* one feeder at a time; `camera` changes only under it */
static DEFINE_SPINLOCK(present_lock);	/* and under this, for those who only look whether they should wake up */
static DECLARE_WAIT_QUEUE_HEAD(feed_wait);

static u32 image_octets(const struct camera *c)
{
	return c->width * c->height * c->format->octets_per_pixel;
}

/* ---- buffers ---- */

static int queue_setup(struct vb2_queue *q, unsigned int *buffers, unsigned int *planes, unsigned int sizes[],
		       struct device *devices[])
{
	struct camera *c = vb2_get_drv_priv(q);

	if (*planes)
		return sizes[0] < image_octets(c) ? -EINVAL : 0;
	*planes = 1;
	sizes[0] = image_octets(c);
	return 0;
}

static int buffer_prepare(struct vb2_buffer *vb)
{
	struct camera *c = vb2_get_drv_priv(vb->vb2_queue);

	if (vb2_plane_size(vb, 0) < image_octets(c))
		return -EINVAL;
	vb2_set_plane_payload(vb, 0, image_octets(c));
	return 0;
}

static void buffer_queue(struct vb2_buffer *vb)
{
	struct camera *c = vb2_get_drv_priv(vb->vb2_queue);
	struct frame_buffer *buffer = container_of(to_vb2_v4l2_buffer(vb), struct frame_buffer, vb);
	unsigned long flags;

	spin_lock_irqsave(&c->buffers_lock, flags);
	list_add_tail(&buffer->list, &c->buffers);
	c->queued++;
	spin_unlock_irqrestore(&c->buffers_lock, flags);
	wake_up(&feed_wait);
}

static struct frame_buffer *take_buffer(struct camera *c)
{
	struct frame_buffer *buffer;
	unsigned long flags;

	spin_lock_irqsave(&c->buffers_lock, flags);
	buffer = list_first_entry_or_null(&c->buffers, struct frame_buffer, list);
	if (buffer) {
		list_del(&buffer->list);
		c->queued--;
	}
	spin_unlock_irqrestore(&c->buffers_lock, flags);
	return buffer;
}

static int start_streaming(struct vb2_queue *q, unsigned int count)
{
	struct camera *c = vb2_get_drv_priv(q);

	c->sequence = 0;
	c->failed = false;
	c->streaming = true;
	wake_up(&feed_wait);
	return 0;
}

static void stop_streaming(struct vb2_queue *q)
{
	struct camera *c = vb2_get_drv_priv(q);
	struct frame_buffer *buffer;

	c->streaming = false;
	while ((buffer = take_buffer(c)))
		vb2_buffer_done(&buffer->vb.vb2_buf, VB2_BUF_STATE_ERROR);
	wake_up(&feed_wait);
}

static const struct vb2_ops queue_ops = {
	.queue_setup = queue_setup,
	.buf_prepare = buffer_prepare,
	.buf_queue = buffer_queue,
	.start_streaming = start_streaming,
	.stop_streaming = stop_streaming,
	.wait_prepare = vb2_ops_wait_prepare,
	.wait_finish = vb2_ops_wait_finish,
};

/* ---- what the device says of itself ---- */

static int query_capabilities(struct file *file, void *fh, struct v4l2_capability *capability)
{
	strscpy(capability->driver, "filecam", sizeof(capability->driver));
	strscpy(capability->card, "filecam", sizeof(capability->card));
	strscpy(capability->bus_info, "platform:filecam", sizeof(capability->bus_info));
	return 0;
}

static int enumerate_formats(struct file *file, void *fh, struct v4l2_fmtdesc *description)
{
	if (description->index >= ARRAY_SIZE(formats))
		return -EINVAL;
	description->pixelformat = formats[description->index].fourcc;
	return 0;
}

static const struct format *find_format(u32 fourcc)
{
	size_t i;

	for (i = 0; i < ARRAY_SIZE(formats); i++)
		if (formats[i].fourcc == fourcc)
			return &formats[i];
	return &formats[0];
}

static void describe(const struct format *format, u32 width, u32 height, struct v4l2_pix_format *pix)
{
	pix->width = width;
	pix->height = height;
	pix->pixelformat = format->fourcc;
	pix->field = V4L2_FIELD_NONE;
	pix->bytesperline = width * format->octets_per_pixel;
	pix->sizeimage = pix->bytesperline * height;
	pix->colorspace = V4L2_COLORSPACE_RAW;
}

static int get_format(struct file *file, void *fh, struct v4l2_format *f)
{
	struct camera *c = video_drvdata(file);

	describe(c->format, c->width, c->height, &f->fmt.pix);
	return 0;
}

static int try_format(struct file *file, void *fh, struct v4l2_format *f)
{
	struct v4l2_pix_format *pix = &f->fmt.pix;

	describe(find_format(pix->pixelformat), clamp(pix->width, SIDE_MIN, WIDTH_MAX) & ~1u,
		 clamp(pix->height, SIDE_MIN, HEIGHT_MAX) & ~1u, pix);
	return 0;
}

static int set_format(struct file *file, void *fh, struct v4l2_format *f)
{
	struct camera *c = video_drvdata(file);

	if (vb2_is_busy(&c->queue))
		return -EBUSY;
	try_format(file, fh, f);
	c->format = find_format(f->fmt.pix.pixelformat);
	c->width = f->fmt.pix.width;
	c->height = f->fmt.pix.height;
	return 0;
}

static int get_interval(struct file *file, void *fh, struct v4l2_streamparm *parameters)
{
	struct camera *c = video_drvdata(file);

	parameters->parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
	parameters->parm.capture.timeperframe = c->interval;
	parameters->parm.capture.readbuffers = 2;
	return 0;
}

static int set_interval(struct file *file, void *fh, struct v4l2_streamparm *parameters)
{
	struct camera *c = video_drvdata(file);
	const struct v4l2_fract wished = parameters->parm.capture.timeperframe;

	if (wished.numerator && wished.denominator)
		c->interval = wished;
	return get_interval(file, fh, parameters);
}

static int enumerate_inputs(struct file *file, void *fh, struct v4l2_input *input)
{
	if (input->index)
		return -EINVAL;
	strscpy(input->name, "file", sizeof(input->name));
	input->type = V4L2_INPUT_TYPE_CAMERA;
	return 0;
}

static int get_input(struct file *file, void *fh, unsigned int *input)
{
	*input = 0;
	return 0;
}

static int set_input(struct file *file, void *fh, unsigned int input)
{
	return input ? -EINVAL : 0;
}

static const struct v4l2_ioctl_ops ioctl_ops = {
	.vidioc_querycap = query_capabilities,
	.vidioc_enum_fmt_vid_cap = enumerate_formats,
	.vidioc_g_fmt_vid_cap = get_format,
	.vidioc_try_fmt_vid_cap = try_format,
	.vidioc_s_fmt_vid_cap = set_format,
	.vidioc_g_parm = get_interval,
	.vidioc_s_parm = set_interval,
	.vidioc_enum_input = enumerate_inputs,
	.vidioc_g_input = get_input,
	.vidioc_s_input = set_input,
	.vidioc_reqbufs = vb2_ioctl_reqbufs,
	.vidioc_create_bufs = vb2_ioctl_create_bufs,
	.vidioc_prepare_buf = vb2_ioctl_prepare_buf,
	.vidioc_querybuf = vb2_ioctl_querybuf,
	.vidioc_qbuf = vb2_ioctl_qbuf,
	.vidioc_dqbuf = vb2_ioctl_dqbuf,
	.vidioc_expbuf = vb2_ioctl_expbuf,
	.vidioc_streamon = vb2_ioctl_streamon,
	.vidioc_streamoff = vb2_ioctl_streamoff,
	.vidioc_log_status = v4l2_ctrl_log_status,
	.vidioc_subscribe_event = v4l2_ctrl_subscribe_event,
	.vidioc_unsubscribe_event = v4l2_event_unsubscribe,
};

static const struct v4l2_file_operations file_ops = {
	.owner = THIS_MODULE,
	.open = v4l2_fh_open,
	.release = vb2_fop_release,
	.read = vb2_fop_read,
	.poll = vb2_fop_poll,
	.unlocked_ioctl = video_ioctl2,
	.mmap = vb2_fop_mmap,
};

/* The feeder reads the values: it plays the sensor. */
static int accept_control(struct v4l2_ctrl *control)
{
	return 0;
}

static const struct v4l2_ctrl_ops control_ops = { .s_ctrl = accept_control };

/* ---- plugging and unplugging ---- */

static void release_camera(struct v4l2_device *v4l2)
{
	struct camera *c = container_of(v4l2, struct camera, v4l2);

	v4l2_ctrl_handler_free(&c->controls);
	mutex_destroy(&c->lock);
	kfree(c);
}

static void release_video(struct video_device *video)
{
	struct camera *c = container_of(video, struct camera, video);

	v4l2_device_put(&c->v4l2);
}

static int add_controls(struct camera *c)
{
	v4l2_ctrl_handler_init(&c->controls, 3);
	c->exposure = v4l2_ctrl_new_std(&c->controls, &control_ops, V4L2_CID_EXPOSURE_ABSOLUTE, 1, 10000, 1, 100);
	c->gain = v4l2_ctrl_new_std(&c->controls, &control_ops, V4L2_CID_GAIN, 0, 480, 1, 16);
	v4l2_ctrl_new_std_menu(&c->controls, &control_ops, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, 0,
			       V4L2_EXPOSURE_MANUAL);
	c->v4l2.ctrl_handler = &c->controls;
	return c->controls.error;
}

static int add_queue(struct camera *c)
{
	struct vb2_queue *q = &c->queue;

	q->type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
	q->io_modes = VB2_MMAP | VB2_DMABUF | VB2_READ;
	q->drv_priv = c;
	q->buf_struct_size = sizeof(struct frame_buffer);
	q->ops = &queue_ops;
	q->mem_ops = &vb2_vmalloc_memops;
	q->timestamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
	q->min_buffers_needed = 2;
	q->lock = &c->lock;
	q->dev = &parent->dev;
	return vb2_queue_init(q);
}

static int add_video(struct camera *c)
{
	struct video_device *video = &c->video;

	strscpy(video->name, "filecam", sizeof(video->name));
	video->fops = &file_ops;
	video->ioctl_ops = &ioctl_ops;
	video->release = release_video;
	video->lock = &c->lock;
	video->queue = &c->queue;
	video->v4l2_dev = &c->v4l2;
	video->device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_READWRITE;
	video_set_drvdata(video, c);
	return video_register_device(video, VFL_TYPE_VIDEO, -1);
}

/* With feed_lock held. */
static int connect(void)
{
	struct camera *c;
	int error;

	if (camera)
		return -EEXIST;
	c = kzalloc(sizeof(*c), GFP_KERNEL);
	if (!c)
		return -ENOMEM;
	c->format = &formats[0];
	c->width = 640;
	c->height = 480;
	c->interval = (struct v4l2_fract){ .numerator = 1, .denominator = 20 };
	mutex_init(&c->lock);
	spin_lock_init(&c->buffers_lock);
	INIT_LIST_HEAD(&c->buffers);
	strscpy(c->v4l2.name, "filecam", sizeof(c->v4l2.name));
	error = v4l2_device_register(&parent->dev, &c->v4l2);
	if (error) {
		kfree(c);
		return error;
	}
	c->v4l2.release = release_camera;
	error = add_controls(c);
	if (!error)
		error = add_queue(c);
	if (!error)
		error = add_video(c);
	if (error) {
		v4l2_device_put(&c->v4l2);
		return error;
	}
	spin_lock(&present_lock);
	camera = c;
	spin_unlock(&present_lock);
	return 0;
}

/* With feed_lock held. */
static void disconnect(void)
{
	struct camera *c = camera;

	if (!c)
		return;
	spin_lock(&present_lock);
	camera = NULL;
	spin_unlock(&present_lock);
	wake_up(&feed_wait);
	/* Stops the stream; the last descriptor's close frees the rest. */
	v4l2_device_get(&c->v4l2);
	vb2_video_unregister_device(&c->video);
	v4l2_device_disconnect(&c->v4l2);
	v4l2_device_put(&c->v4l2);
}

/* ---- the feeder's side ---- */

static int deliver(struct camera *c, const struct filecam_header *header, const char __user *pixels)
{
	struct frame_buffer *buffer;
	struct vb2_buffer *vb;
	u32 octets;
	int error;

	mutex_lock(&c->lock);	/* else the stream might stop with a buffer in our hands */
	buffer = take_buffer(c);
	if (!buffer) {
		mutex_unlock(&c->lock);
		return -EAGAIN;
	}
	vb = &buffer->vb.vb2_buf;
	octets = min_t(u32, header->octets, vb2_plane_size(vb, 0));
	error = copy_from_user(vb2_plane_vaddr(vb, 0), pixels, octets) ? -EFAULT : 0;
	vb2_set_plane_payload(vb, 0, octets);
	c->sequence += header->sequence_skip;
	buffer->vb.sequence = c->sequence++;
	buffer->vb.field = V4L2_FIELD_NONE;
	vb->timestamp = header->timestamp_ns ? header->timestamp_ns : ktime_get_ns();
	vb2_buffer_done(vb, error || (header->flags & FILECAM_FLAG_DAMAGED) ? VB2_BUF_STATE_ERROR : VB2_BUF_STATE_DONE);
	mutex_unlock(&c->lock);
	return error;
}

static bool ready_for_frame(void)
{
	bool ready;

	spin_lock(&present_lock);
	ready = camera && camera->streaming && !camera->failed && camera->queued;
	spin_unlock(&present_lock);
	return ready;
}

static int feed_frame(struct file *file, const struct filecam_header *header, const char __user *pixels)
{
	int error;

	while (!ready_for_frame()) {
		mutex_unlock(&feed_lock);
		error = file->f_flags & O_NONBLOCK ? -EAGAIN : wait_event_interruptible(feed_wait, ready_for_frame());
		mutex_lock(&feed_lock);
		if (error)
			return error;
	}
	return deliver(camera, header, pixels);
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
		if (camera) {
			camera->failed = true;
			vb2_queue_error(&camera->queue);
		}
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
			.pixel_format = camera->format->fourcc,
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

static int __init filecam_init(void)
{
	int error;

	parent = platform_device_register_simple("filecam", -1, NULL, 0);
	if (IS_ERR(parent))
		return PTR_ERR(parent);
	error = connect();
	if (!error)
		error = misc_register(&feed_device);
	if (error) {
		disconnect();
		platform_device_unregister(parent);
	}
	return error;
}

static void __exit filecam_exit(void)
{
	misc_deregister(&feed_device);
	disconnect();
	platform_device_unregister(parent);
}

module_init(filecam_init);
module_exit(filecam_exit);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("File-fed V4L2 test camera");
