// SPDX-License-Identifier: GPL-2.0-only
/* Buffers, from queued to filled. */
#include <linux/uaccess.h>
#include <media/videobuf2-vmalloc.h>

#include "camera.h"

struct frame_buffer {
	struct vb2_v4l2_buffer vb;	/* first: vb2 allocates the whole */
	struct list_head list;
};

u32 filecam_image_octets(const struct filecam *c)
{
	return c->width * c->height * c->pixels->octets_per_pixel;
}

static int queue_setup(struct vb2_queue *q, unsigned int *buffers, unsigned int *planes, unsigned int sizes[],
		       struct device *devices[])
{
	struct filecam *c = vb2_get_drv_priv(q);

	if (*planes)
		return sizes[0] < filecam_image_octets(c) ? -EINVAL : 0;
	*planes = 1;
	sizes[0] = filecam_image_octets(c);
	return 0;
}

static int buffer_prepare(struct vb2_buffer *vb)
{
	struct filecam *c = vb2_get_drv_priv(vb->vb2_queue);

	if (vb2_plane_size(vb, 0) < filecam_image_octets(c))
		return -EINVAL;
	vb2_set_plane_payload(vb, 0, filecam_image_octets(c));
	return 0;
}

static void buffer_queue(struct vb2_buffer *vb)
{
	struct filecam *c = vb2_get_drv_priv(vb->vb2_queue);
	struct frame_buffer *buffer = container_of(to_vb2_v4l2_buffer(vb), struct frame_buffer, vb);
	unsigned long flags;

	spin_lock_irqsave(&c->buffers_lock, flags);
	list_add_tail(&buffer->list, &c->buffers);
	c->queued++;
	spin_unlock_irqrestore(&c->buffers_lock, flags);
	wake_up(c->feed_wait);
}

static struct frame_buffer *take_buffer(struct filecam *c)
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
	struct filecam *c = vb2_get_drv_priv(q);

	c->sequence = 0;
	c->failed = false;
	c->streaming = true;
	wake_up(c->feed_wait);
	return 0;
}

static void stop_streaming(struct vb2_queue *q)
{
	struct filecam *c = vb2_get_drv_priv(q);
	struct frame_buffer *buffer;

	c->streaming = false;
	while ((buffer = take_buffer(c)))
		vb2_buffer_done(&buffer->vb.vb2_buf, VB2_BUF_STATE_ERROR);
	wake_up(c->feed_wait);
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

int filecam_init_queue(struct filecam *c, struct device *device)
{
	struct vb2_queue *q = &c->queue;

	spin_lock_init(&c->buffers_lock);
	INIT_LIST_HEAD(&c->buffers);
	q->type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
	q->io_modes = VB2_MMAP | VB2_DMABUF | VB2_READ;
	q->drv_priv = c;
	q->buf_struct_size = sizeof(struct frame_buffer);
	q->ops = &queue_ops;
	q->mem_ops = &vb2_vmalloc_memops;
	q->timestamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
	q->min_buffers_needed = 2;
	q->lock = &c->lock;
	q->dev = device;
	return vb2_queue_init(q);
}

/* With c->lock held, else the stream might stop with a buffer in our hands. */
static int fill(struct filecam *c, struct frame_buffer *buffer, const struct filecam_header *header,
		const char __user *pixels)
{
	struct vb2_buffer *vb = &buffer->vb.vb2_buf;
	const u32 octets = min_t(u32, header->octets, vb2_plane_size(vb, 0));
	const bool unreadable = copy_from_user(vb2_plane_vaddr(vb, 0), pixels, octets);
	const bool damaged = unreadable || (header->flags & FILECAM_FLAG_DAMAGED);

	vb2_set_plane_payload(vb, 0, octets);
	c->sequence += header->sequence_skip;
	buffer->vb.sequence = c->sequence++;
	buffer->vb.field = V4L2_FIELD_NONE;
	vb->timestamp = header->timestamp_ns ? header->timestamp_ns : ktime_get_ns();
	vb2_buffer_done(vb, damaged ? VB2_BUF_STATE_ERROR : VB2_BUF_STATE_DONE);
	return unreadable ? -EFAULT : 0;
}

int filecam_deliver(struct filecam *c, const struct filecam_header *header, const char __user *pixels)
{
	struct frame_buffer *buffer;
	int error = -EAGAIN;

	mutex_lock(&c->lock);
	buffer = take_buffer(c);
	if (buffer)
		error = fill(c, buffer, header, pixels);
	mutex_unlock(&c->lock);
	return error;
}
