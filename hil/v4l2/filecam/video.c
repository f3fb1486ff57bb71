// SPDX-License-Identifier: GPL-2.0-only
/* What the device says of itself: capabilities, formats, interval, input. */
#include <media/v4l2-event.h>
#include <media/v4l2-ioctl.h>

#include "camera.h"

#define SIDE_MIN 16u
#define WIDTH_MAX 4096u
#define HEIGHT_MAX 3072u
#define SIDE_STEP 2u

static const struct filecam_pixels formats[] = {
	{ V4L2_PIX_FMT_GREY, 1 },
	{ V4L2_PIX_FMT_Y10, 2 },
	{ V4L2_PIX_FMT_Y12, 2 },
	{ V4L2_PIX_FMT_Y16, 2 },
};

static int query_capabilities(struct file *file, void *fh, struct v4l2_capability *capability)
{
	strscpy(capability->driver, "filecam", sizeof(capability->driver));
	strscpy(capability->card, "filecam", sizeof(capability->card));
	strscpy(capability->bus_info, "platform:filecam", sizeof(capability->bus_info));
	return 0;
}

static const struct filecam_pixels *find_format(u32 fourcc)
{
	size_t i;

	for (i = 0; i < ARRAY_SIZE(formats); i++)
		if (formats[i].fourcc == fourcc)
			return &formats[i];
	return NULL;
}

static int enumerate_formats(struct file *file, void *fh, struct v4l2_fmtdesc *description)
{
	if (description->index >= ARRAY_SIZE(formats))
		return -EINVAL;
	description->pixelformat = formats[description->index].fourcc;
	return 0;
}

static int enumerate_sizes(struct file *file, void *fh, struct v4l2_frmsizeenum *size)
{
	if (size->index || !find_format(size->pixel_format))
		return -EINVAL;
	size->type = V4L2_FRMSIZE_TYPE_STEPWISE;
	size->stepwise = (struct v4l2_frmsize_stepwise){
		.min_width = SIDE_MIN,
		.max_width = WIDTH_MAX,
		.step_width = SIDE_STEP,
		.min_height = SIDE_MIN,
		.max_height = HEIGHT_MAX,
		.step_height = SIDE_STEP,
	};
	return 0;
}

static void describe(const struct filecam_pixels *pixels, u32 width, u32 height, struct v4l2_pix_format *pix)
{
	pix->width = width;
	pix->height = height;
	pix->pixelformat = pixels->fourcc;
	pix->field = V4L2_FIELD_NONE;
	pix->bytesperline = width * pixels->octets_per_pixel;
	pix->sizeimage = pix->bytesperline * height;
	pix->colorspace = V4L2_COLORSPACE_RAW;
}

static int get_format(struct file *file, void *fh, struct v4l2_format *f)
{
	struct filecam *c = video_drvdata(file);

	describe(c->pixels, c->width, c->height, &f->fmt.pix);
	return 0;
}

/* What is not on offer is answered with what comes nearest, as V4L2 wants it. */
static int try_format(struct file *file, void *fh, struct v4l2_format *f)
{
	struct v4l2_pix_format *pix = &f->fmt.pix;
	const struct filecam_pixels *pixels = find_format(pix->pixelformat);

	describe(pixels ? pixels : &formats[0], clamp(pix->width, SIDE_MIN, WIDTH_MAX) & ~(SIDE_STEP - 1),
		 clamp(pix->height, SIDE_MIN, HEIGHT_MAX) & ~(SIDE_STEP - 1), pix);
	return 0;
}

static int set_format(struct file *file, void *fh, struct v4l2_format *f)
{
	struct filecam *c = video_drvdata(file);

	if (vb2_is_busy(&c->queue))
		return -EBUSY;
	try_format(file, fh, f);
	c->pixels = find_format(f->fmt.pix.pixelformat);
	c->width = f->fmt.pix.width;
	c->height = f->fmt.pix.height;
	return 0;
}

static int get_interval(struct file *file, void *fh, struct v4l2_streamparm *parameters)
{
	struct filecam *c = video_drvdata(file);

	parameters->parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
	parameters->parm.capture.timeperframe = c->interval;
	parameters->parm.capture.readbuffers = 2;
	return 0;
}

/* Any interval: a frame comes when it is fed. */
static int set_interval(struct file *file, void *fh, struct v4l2_streamparm *parameters)
{
	struct filecam *c = video_drvdata(file);
	const struct v4l2_fract requested = parameters->parm.capture.timeperframe;

	if (requested.numerator && requested.denominator)
		c->interval = requested;
	return get_interval(file, fh, parameters);
}

static int enumerate_intervals(struct file *file, void *fh, struct v4l2_frmivalenum *interval)
{
	const bool in_range = interval->width >= SIDE_MIN && interval->width <= WIDTH_MAX && interval->height >= SIDE_MIN &&
			      interval->height <= HEIGHT_MAX;
	const bool in_step = !(interval->width % SIDE_STEP) && !(interval->height % SIDE_STEP);

	if (interval->index || !in_range || !in_step || !find_format(interval->pixel_format))
		return -EINVAL;
	interval->type = V4L2_FRMIVAL_TYPE_CONTINUOUS;
	interval->stepwise = (struct v4l2_frmival_stepwise){ .min = { 1, 1000 }, .max = { 1000, 1 }, .step = { 1, 1 } };
	return 0;
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
	.vidioc_enum_framesizes = enumerate_sizes,
	.vidioc_enum_frameintervals = enumerate_intervals,
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

void filecam_set_defaults(struct filecam *c)
{
	c->pixels = &formats[0];
	c->width = 640;
	c->height = 480;
	c->interval = (struct v4l2_fract){ .numerator = 1, .denominator = 20 };
}

int filecam_register_video(struct filecam *c, void (*release)(struct video_device *video))
{
	struct video_device *video = &c->video;

	strscpy(video->name, "filecam", sizeof(video->name));
	video->fops = &file_ops;
	video->ioctl_ops = &ioctl_ops;
	video->release = release;
	video->lock = &c->lock;
	video->queue = &c->queue;
	video->v4l2_dev = &c->v4l2;
	video->device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_READWRITE;
	video_set_drvdata(video, c);
	return video_register_device(video, VFL_TYPE_VIDEO, -1);
}
