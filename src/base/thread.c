// SPDX-License-Identifier: Apache-2.0
#include "base/thread.h"

#include <pthread.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>
#ifdef __linux__
#include <sched.h>
#endif

// Jobs of a frame follow each other closely, and waking a thread takes as long as a small job: before a thread sleeps, it
// looks so many times whether what it waits for has come. About twenty microseconds.
enum { LOOKS = 400 };

// One job at a time. Its owner and the workers take chunks by an atomic counter; which thread runs a chunk is the only
// thing that timing decides.
typedef struct clast_pool {
    pthread_mutex_t owner;  // held while a job is under way
    pthread_mutex_t lock;   // guards what follows
    pthread_cond_t posted;  // a job is there, or the pool ends
    pthread_cond_t settled; // no worker is busy any more
    atomic_uint_fast64_t generation;
    bool open;        // workers may join the job: its owner does not wait for those that wake too late
    atomic_uint busy; // workers that have joined it
    atomic_bool ending;
    uint32_t looks; // none where threads would have to share processors
    clast_range_function function;
    void *data;
    size_t count;
    size_t grain;
    atomic_size_t next_chunk;
    uint32_t thread_count; // workers beside the calling thread
    pthread_t threads[];
} clast_pool;

typedef struct pool_entry {
    clast_pool *pool;
    uint32_t worker;
} pool_entry;

static _Thread_local bool inside_a_job;

static void run_chunks(clast_pool *pool, uint32_t worker)
{
    inside_a_job = true;
    for (;;) {
        size_t chunk = atomic_fetch_add(&pool->next_chunk, 1);
        if (chunk > pool->count / pool->grain || chunk * pool->grain >= pool->count) {
            break;
        }
        size_t begin = chunk * pool->grain;
        size_t end = pool->count - begin < pool->grain ? pool->count : begin + pool->grain;
        pool->function(pool->data, begin, end, worker);
    }
    inside_a_job = false;
}

static void pause_briefly(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("isb");
#endif
}

static void look_for_job(clast_pool *pool, uint64_t seen)
{
    for (uint32_t i = 0; i < pool->looks && atomic_load(&pool->generation) == seen && !atomic_load(&pool->ending);
         i++) {
        pause_briefly();
    }
}

static void look_for_end(clast_pool *pool)
{
    for (uint32_t i = 0; i < pool->looks && atomic_load(&pool->busy) != 0; i++) {
        pause_briefly();
    }
}

static void *worker_main(void *data)
{
    pool_entry entry = *(pool_entry *)data;
    clast_pool *pool = entry.pool;
    uint64_t seen = 0;
    pthread_mutex_lock(&pool->lock);
    pool->busy--; // the entry has been read
    pthread_cond_signal(&pool->settled);
    for (;;) {
        if (seen != 0) {
            pthread_mutex_unlock(&pool->lock);
            look_for_job(pool, seen);
            pthread_mutex_lock(&pool->lock);
        }
        while (pool->generation == seen && !pool->ending) {
            pthread_cond_wait(&pool->posted, &pool->lock);
        }
        if (pool->ending) {
            break;
        }
        seen = pool->generation;
        if (!pool->open) {
            continue;
        }
        pool->busy++;
        pthread_mutex_unlock(&pool->lock);
        run_chunks(pool, entry.worker);
        pthread_mutex_lock(&pool->lock);
        if (--pool->busy == 0) {
            pthread_cond_signal(&pool->settled);
        }
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

clast_status clast_pool_create(clast_context *context, uint32_t threads, clast_pool **result)
{
    uint32_t workers = threads > 0 ? threads - 1 : 0;
    clast_pool *pool = clast_allocate_zeroed(context, 1, sizeof *pool + workers * sizeof(pthread_t));
    if (pool == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    pool->looks = threads <= clast_processor_count() ? LOOKS : 0;
    pthread_mutex_init(&pool->owner, NULL);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->posted, NULL);
    pthread_cond_init(&pool->settled, NULL);
    for (uint32_t i = 0; i < workers; i++) {
        pool_entry entry = {pool, i + 1};
        pthread_mutex_lock(&pool->lock);
        pool->busy = 1;
        int failed = pthread_create(&pool->threads[i], NULL, worker_main, &entry);
        while (failed == 0 && pool->busy != 0) {
            pthread_cond_wait(&pool->settled, &pool->lock);
        }
        pool->busy = 0;
        pthread_mutex_unlock(&pool->lock);
        if (failed != 0) {
            clast_pool_destroy(context, pool);
            return clast_fail(context, CLAST_ERROR_THREAD, "thread %u of %u could not be started", i + 1, workers);
        }
        pool->thread_count = i + 1;
    }
    *result = pool;
    return CLAST_OK;
}

void clast_pool_destroy(clast_context *context, clast_pool *pool)
{
    pthread_mutex_lock(&pool->lock);
    pool->ending = true;
    pthread_cond_broadcast(&pool->posted);
    pthread_mutex_unlock(&pool->lock);
    for (uint32_t i = 0; i < pool->thread_count; i++) {
        pthread_join(pool->threads[i], NULL);
    }
    pthread_cond_destroy(&pool->settled);
    pthread_cond_destroy(&pool->posted);
    pthread_mutex_destroy(&pool->lock);
    pthread_mutex_destroy(&pool->owner);
    clast_free(context, pool);
}

// The same chunks as on many threads, for callers that rely on where they begin.
static void run_alone(size_t count, size_t grain, clast_range_function function, void *data)
{
    for (size_t begin = 0; begin < count;) {
        size_t end = count - begin < grain ? count : begin + grain;
        function(data, begin, end, 0);
        begin = end;
    }
}

void clast_parallel_for(clast_context *context, size_t count, size_t grain, clast_range_function function, void *data)
{
    clast_pool *pool = clast_context_pool(context);
    grain = grain != 0 ? grain : 1;
    if (pool->thread_count == 0 || count <= grain || inside_a_job || pthread_mutex_trylock(&pool->owner) != 0) {
        run_alone(count, grain, function, data);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    pool->function = function;
    pool->data = data;
    pool->count = count;
    pool->grain = grain;
    atomic_store(&pool->next_chunk, 0);
    pool->open = true;
    pool->generation++;
    pthread_cond_broadcast(&pool->posted);
    pthread_mutex_unlock(&pool->lock);
    run_chunks(pool, 0);
    pthread_mutex_lock(&pool->lock);
    pool->open = false; // all chunks are taken
    if (pool->busy != 0) {
        pthread_mutex_unlock(&pool->lock);
        look_for_end(pool);
        pthread_mutex_lock(&pool->lock);
    }
    while (pool->busy != 0) {
        pthread_cond_wait(&pool->settled, &pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
    pthread_mutex_unlock(&pool->owner);
}

uint32_t clast_worker_count(const clast_context *context)
{
    return clast_context_threads(context);
}

uint32_t clast_processor_count(void)
{
    long count = 0;
#ifdef __linux__
    cpu_set_t set; // what the process may use, not what the machine has
    if (sched_getaffinity(0, sizeof set, &set) == 0) {
        count = CPU_COUNT(&set);
    }
#endif
    if (count <= 0) {
        count = sysconf(_SC_NPROCESSORS_ONLN);
    }
    return count < 1 ? 1 : count > CLAST_THREADS_MOST ? CLAST_THREADS_MOST : (uint32_t)count;
}

double clast_clock(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

uint64_t clast_process_memory_peak(void)
{
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0) {
        return 0;
    }
    return (uint64_t)usage.ru_maxrss * 1024; // kibibytes on Linux
}
