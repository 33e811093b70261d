// SPDX-License-Identifier: Apache-2.0
// Copies between the processor's memory and the device's, through staging buffers that are used again.
#include "vulkan/device.h"

#include <string.h>

static const uint64_t staging_bytes = (uint64_t)8 << 20; // of a staging buffer, unless a piece is larger
static const uint64_t inline_bytes = 65536;              // the most that one command of a command buffer can hold
static const uint64_t piece_bytes = (uint64_t)64 << 20;  // that a copy goes through at a time
static const uint64_t staged_most = (uint64_t)256 << 20; // before what was recorded is run
enum { PIECE_ALIGNMENT = 16 };                           // texels of any format

static bool add_staging(clast_gpu_commands *commands, int direction, uint64_t bytes)
{
    clast_gpu *gpu = commands->gpu;
    size_t count = commands->staging_count[direction];
    clast_status status = CLAST_RESERVE(gpu->context, commands->staging[direction],
                                        commands->staging_capacity[direction], count + 1);
    if (status == CLAST_OK) {
        clast_gpu_staging *added = &commands->staging[direction][count];
        added->used = 0;
        status = clast_gpu_allocate(gpu, direction == 0 ? CLAST_GPU_UPLOAD : CLAST_GPU_READBACK,
                                    bytes > staging_bytes ? bytes : staging_bytes, "a staging buffer", &added->buffer);
    }
    if (status != CLAST_OK) {
        clast_gpu_note(commands, status);
        return false;
    }
    commands->staging_count[direction]++;
    return true;
}

bool clast_gpu_stage(clast_gpu_commands *commands, int direction, uint64_t bytes, clast_gpu_buffer *piece)
{
    if (commands->staged[direction] + bytes > staged_most) {
        clast_gpu_flush(commands);
    }
    if (commands->status != CLAST_OK) {
        return false;
    }
    size_t i = 0;
    for (; i < commands->staging_count[direction]; i++) {
        const clast_gpu_staging *at = &commands->staging[direction][i];
        if (at->buffer.bytes - at->used >= bytes) {
            break;
        }
    }
    if (i == commands->staging_count[direction] && !add_staging(commands, direction, bytes)) {
        return false;
    }
    clast_gpu_staging *staging = &commands->staging[direction][i];
    *piece = staging->buffer;
    piece->offset += staging->used;
    piece->mapped = (char *)piece->mapped + staging->used;
    piece->bytes = bytes;
    uint64_t used = staging->used + (bytes + PIECE_ALIGNMENT - 1) / PIECE_ALIGNMENT * PIECE_ALIGNMENT;
    staging->used = used < staging->buffer.bytes ? used : staging->buffer.bytes;
    commands->staged[direction] += bytes;
    return true;
}

void clast_gpu_free_staging(clast_gpu_commands *commands)
{
    for (int direction = 0; direction < 2; direction++) {
        for (size_t i = 0; i < commands->staging_count[direction]; i++) {
            clast_gpu_free(commands->gpu, &commands->staging[direction][i].buffer);
        }
        clast_free(commands->gpu->context, commands->staging[direction]);
        commands->staging[direction] = NULL;
        commands->staging_count[direction] = commands->staging_capacity[direction] = 0;
    }
}

static bool is_within(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset, uint64_t bytes)
{
    if (offset <= buffer->bytes && bytes <= buffer->bytes - offset) {
        return true;
    }
    clast_gpu_note(commands, clast_fail(commands->gpu->context, CLAST_ERROR_INVALID_ARGUMENT,
                                        "vulkan: a copy of %llu bytes at %llu is outside its buffer of %llu",
                                        (unsigned long long)bytes, (unsigned long long)offset,
                                        (unsigned long long)buffer->bytes));
    return false;
}

static void copy(clast_gpu_commands *commands, const clast_gpu_buffer *to, uint64_t to_offset,
                 const clast_gpu_buffer *from, uint64_t from_offset, uint64_t bytes)
{
    VkBufferCopy region = {from->offset + from_offset, to->offset + to_offset, bytes};
    commands->gpu->vk.vkCmdCopyBuffer(commands->buffer, from->handle, to->handle, 1, &region);
}

void clast_gpu_copy(clast_gpu_commands *commands, const clast_gpu_buffer *to, uint64_t to_offset,
                    const clast_gpu_buffer *from, uint64_t from_offset, uint64_t bytes)
{
    if (bytes != 0 && commands->status == CLAST_OK && is_within(commands, to, to_offset, bytes) &&
        is_within(commands, from, from_offset, bytes)) {
        copy(commands, to, to_offset, from, from_offset, bytes);
    }
}

void clast_gpu_fill(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset, uint64_t bytes,
                    uint32_t value)
{
    if (bytes != 0 && commands->status == CLAST_OK && is_within(commands, buffer, offset, bytes)) {
        commands->gpu->vk.vkCmdFillBuffer(commands->buffer, buffer->handle, buffer->offset + offset, bytes, value);
    }
}

// Into the commands themselves: for those of a caller, who does not tell when a staging buffer would be free again.
static void write_inline(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset,
                         const void *data, uint64_t bytes)
{
    for (uint64_t done = 0; done < bytes; done += inline_bytes) {
        uint64_t length = bytes - done < inline_bytes ? bytes - done : inline_bytes;
        commands->gpu->vk.vkCmdUpdateBuffer(commands->buffer, buffer->handle, buffer->offset + offset + done, length,
                                            (const char *)data + done);
    }
}

void clast_gpu_write(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset, const void *data,
                     uint64_t bytes)
{
    if (bytes == 0 || commands->status != CLAST_OK || !is_within(commands, buffer, offset, bytes)) {
        return;
    }
    if (commands->pool == VK_NULL_HANDLE && bytes % 4 == 0 && offset % 4 == 0) {
        write_inline(commands, buffer, offset, data, bytes);
        return;
    }
    for (uint64_t done = 0; done < bytes;) {
        uint64_t length = bytes - done < piece_bytes ? bytes - done : piece_bytes;
        clast_gpu_buffer piece;
        if (!clast_gpu_stage(commands, 0, length, &piece)) {
            return;
        }
        memcpy(piece.mapped, (const char *)data + done, length);
        copy(commands, buffer, offset + done, &piece, 0, length);
        done += length;
    }
}

void clast_gpu_read(clast_gpu_commands *commands, const clast_gpu_buffer *buffer, uint64_t offset, void *to,
                    uint64_t bytes)
{
    if (bytes == 0 || commands->status != CLAST_OK || !is_within(commands, buffer, offset, bytes)) {
        return;
    }
    clast_gpu_barrier(commands);
    for (uint64_t done = 0; done < bytes;) {
        uint64_t length = bytes - done < piece_bytes ? bytes - done : piece_bytes;
        clast_gpu_buffer piece;
        if (!clast_gpu_stage(commands, 1, length, &piece)) {
            return;
        }
        clast_status status = CLAST_RESERVE(commands->gpu->context, commands->deliveries, commands->delivery_capacity,
                                            commands->delivery_count + 1);
        if (status != CLAST_OK) {
            clast_gpu_note(commands, status);
            return;
        }
        copy(commands, &piece, 0, buffer, offset + done, length);
        commands->deliveries[commands->delivery_count++] = (clast_gpu_delivery){(char *)to + done, piece.mapped,
                                                                                length};
        done += length;
    }
}
