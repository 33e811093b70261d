// SPDX-License-Identifier: Apache-2.0
// PNG by libpng, whose memory is clast's. libpng leaves by longjmp: everything that must survive one lies in a struct
// that the function with the setjmp only points to, so that no local is clobbered and nothing leaks.
#include <png.h>

#include <setjmp.h>

#include "load/image.h"

typedef struct png_job {
    clast_context *context;
    clast_file_output *output; // when writing a file
    unsigned char *block;      // when writing into memory
    size_t block_size, block_capacity;
    const char *name;
    clast_bytes bytes;
    uint64_t position;
    bool memory_ran_out;
    char error[160];
    clast_status status; // where it is not the error text that says what went wrong
    png_structp png;
    png_infop info;
    clast_image image;
} png_job;

static void *job_allocate(png_structp png, png_alloc_size_t size)
{
    png_job *job = png_get_mem_ptr(png);
    void *block = clast_allocate(job->context, size, 1);
    job->memory_ran_out = job->memory_ran_out || block == NULL;
    return block;
}

static void job_free(png_structp png, void *block)
{
    png_job *job = png_get_mem_ptr(png);
    clast_free(job->context, block);
}

static void job_error(png_structp png, const char *text)
{
    png_job *job = png_get_error_ptr(png);
    snprintf(job->error, sizeof job->error, "%s", text);
    png_longjmp(png, 1);
}

static void job_warning(png_structp png, const char *text)
{
    (void)png;
    (void)text;
}

static void job_read(png_structp png, png_bytep data, size_t length)
{
    png_job *job = png_get_io_ptr(png);
    if (!clast_bytes_read(job->bytes, job->position, data, length)) {
        png_error(png, "the file ends early");
    }
    job->position += length;
}

static void job_write(png_structp png, png_bytep data, size_t length)
{
    png_job *job = png_get_io_ptr(png);
    if (job->output != NULL) {
        if (clast_file_write(job->output, data, length) != CLAST_OK) {
            png_error(png, "the file could not be written");
        }
        return;
    }
    if (CLAST_RESERVE(job->context, job->block, job->block_capacity, job->block_size + length) != CLAST_OK) {
        job->memory_ran_out = true;
        png_error(png, "memory ran out");
    }
    memcpy(job->block + job->block_size, data, length);
    job->block_size += length;
}

static void job_flush(png_structp png)
{
    (void)png;
}

// Deflate packs at most 1032 bytes in one, so a header that promises more than the file can hold is found out before
// its pixels are allocated.
static bool size_is_possible(const png_job *job)
{
    uint64_t packed = (uint64_t)png_get_rowbytes(job->png, job->info) * png_get_image_height(job->png, job->info);
    return packed / 1032 <= job->bytes.size;
}

static bool read_header(png_job *job)
{
    png_structp png = job->png;
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX); // clast_image_allocate's limits have a clearer text
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, NULL, 0);
    png_set_read_fn(png, job, job_read);
    png_read_info(png, job->info);
    if (!size_is_possible(job)) {
        png_error(png, "the file is too short for the size of its picture");
    }
    png_set_expand(png);
    if (clast_is_little_endian()) {
        png_set_swap(png);
    }
    png_set_interlace_handling(png);
    png_read_update_info(png, job->info);
    clast_pixel_type type = png_get_bit_depth(png, job->info) == 16 ? CLAST_PIXEL_UNORM16 : CLAST_PIXEL_UNORM8;
    job->status = clast_image_allocate(job->context, job->name, job->bytes.size, png_get_image_width(png, job->info),
                                       png_get_image_height(png, job->info), png_get_channels(png, job->info), type,
                                       &job->image);
    return job->status == CLAST_OK;
}

static void read_rows(png_job *job)
{
    bool interlaced = png_get_interlace_type(job->png, job->info) != PNG_INTERLACE_NONE;
    size_t row_size = png_get_rowbytes(job->png, job->info);
    for (int pass = 0; pass < (interlaced ? PNG_INTERLACE_ADAM7_PASSES : 1); pass++) {
        for (uint32_t y = 0; y < job->image.height; y++) {
            png_read_row(job->png, (png_bytep)job->image.pixels + y * row_size, NULL);
        }
    }
    png_read_end(job->png, NULL);
}

static bool run_decode(png_job *job)
{
    if (setjmp(png_jmpbuf(job->png)) != 0) {
        return false;
    }
    if (!read_header(job)) {
        return false;
    }
    read_rows(job);
    return true;
}

static clast_status job_failed(png_job *job)
{
    if (job->status != CLAST_OK) {
        return job->status;
    }
    if (job->memory_ran_out) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    return clast_fail(job->context, CLAST_ERROR_MALFORMED, "%s: PNG: %s", job->name, job->error);
}

clast_status clast_png_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    png_job job = {.context = context, .name = name, .bytes = bytes};
    job.png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, &job, job_error, job_warning, &job, job_allocate,
                                       job_free);
    job.info = job.png != NULL ? png_create_info_struct(job.png) : NULL;
    if (job.info == NULL) {
        png_destroy_read_struct(&job.png, NULL, NULL);
        return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY, "%s: memory ran out", name);
    }
    bool read = run_decode(&job);
    png_destroy_read_struct(&job.png, &job.info, NULL);
    if (!read) {
        clast_image_free(context, &job.image);
        return job_failed(&job);
    }
    *image = job.image;
    return CLAST_OK;
}

static bool run_encode(png_job *job)
{
    static const int types[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                PNG_COLOR_TYPE_RGB_ALPHA};
    if (setjmp(png_jmpbuf(job->png)) != 0) {
        return false;
    }
    const clast_image *image = &job->image;
    size_t size = clast_pixel_size(image->type);
    png_set_write_fn(job->png, job, job_write, job_flush);
    png_set_IHDR(job->png, job->info, image->width, image->height, (int)size * 8, types[image->channels - 1],
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(job->png, job->info);
    if (size == 2 && clast_is_little_endian()) {
        png_set_swap(job->png);
    }
    for (uint32_t y = 0; y < image->height; y++) {
        png_write_row(job->png, (png_const_bytep)image->pixels + (size_t)y * image->width * image->channels * size);
    }
    png_write_end(job->png, NULL);
    return true;
}

// Creates, runs and destroys the encoder; false where that failed.
static bool encode(png_job *job)
{
    job->png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, job, job_error, job_warning, job, job_allocate,
                                         job_free);
    job->info = job->png != NULL ? png_create_info_struct(job->png) : NULL;
    job->memory_ran_out = job->memory_ran_out || job->info == NULL;
    bool written = job->info != NULL && run_encode(job);
    png_destroy_write_struct(&job->png, &job->info);
    return written;
}

void clast_png_encode(clast_file_output *output, const clast_image *image)
{
    png_job job = {.context = output->context, .output = output, .name = output->path, .image = *image};
    if (!encode(&job) && output->status == CLAST_OK) {
        output->status = job.memory_ran_out ? CLAST_ERROR_OUT_OF_MEMORY : CLAST_ERROR_FILE_WRITE;
        clast_fail(output->context, output->status, "%s: PNG: %s", output->path,
                   job.error[0] != '\0' ? job.error : clast_status_text(output->status));
    }
}

clast_status clast_png_encode_block(clast_context *context, const char *name, const clast_image *image, void **block,
                                    size_t *size)
{
    png_job job = {.context = context, .name = name, .image = *image};
    if (!encode(&job)) {
        clast_free(context, job.block);
        return clast_fail(context, job.memory_ran_out ? CLAST_ERROR_OUT_OF_MEMORY : CLAST_ERROR_LIMIT, "%s: PNG: %s",
                          name, job.error);
    }
    *block = job.block;
    *size = job.block_size;
    return CLAST_OK;
}
