/* How long does each step of an FMU of atlas take, and does it allocate?
 *
 *     real_time LIBRARY TOKEN RESOURCES STEP COUNT TORQUE_REFERENCE OUTPUT_REFERENCE...
 *
 * An importer of FMI 3.0: it sets a torque, steps, and reads outputs, so many times. It prints one line of JSON. Allocations are
 * counted by the functions below, which stand before those of the C library.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t),
    *__libc_memalign(size_t, size_t);
static volatile unsigned long allocations;
void *malloc(size_t n) { allocations++; return __libc_malloc(n); }
void *calloc(size_t n, size_t m) { allocations++; return __libc_calloc(n, m); }
void *realloc(void *p, size_t n) { allocations++; return __libc_realloc(p, n); }
void *aligned_alloc(size_t a, size_t n) { allocations++; return __libc_memalign(a, n); }
int posix_memalign(void **p, size_t a, size_t n) { allocations++; *p = __libc_memalign(a, n); return *p ? 0 : 12; }

typedef void *Instance;
#define FUNCTION(result, name, ...) result (*name)(__VA_ARGS__) = (result (*)(__VA_ARGS__))dlsym(library, #name)

static void say(void *environment, int status, const char *category, const char *message)
{
    (void)environment;
    fprintf(stderr, "%d %s: %s\n", status, category, message);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

int main(int count, char **words)
{
    if (count < 8) return 2;
    void *library = dlopen(words[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return fprintf(stderr, "%s\n", dlerror()), 1;
    FUNCTION(Instance, fmi3InstantiateCoSimulation, const char *, const char *, const char *, bool, bool, bool, bool,
             const uint32_t *, size_t, void *, void *, void *);
    FUNCTION(int, fmi3EnterInitializationMode, Instance, bool, double, double, bool, double);
    FUNCTION(int, fmi3ExitInitializationMode, Instance);
    FUNCTION(int, fmi3DoStep, Instance, double, double, bool, bool *, bool *, bool *, double *);
    FUNCTION(int, fmi3GetFloat64, Instance, const uint32_t *, size_t, double *, size_t);
    FUNCTION(int, fmi3SetFloat64, Instance, const uint32_t *, size_t, const double *, size_t);
    FUNCTION(int, fmi3GetInt64, Instance, const uint32_t *, size_t, int64_t *, size_t);
    FUNCTION(int, fmi3Terminate, Instance);
    FUNCTION(void, fmi3FreeInstance, Instance);

    const double step = atof(words[4]);
    const long steps = atol(words[5]);
    const uint32_t input = atoi(words[6]), events = atoi(words[7]);
    uint32_t outputs[64];
    size_t asked = 0;
    for (int i = 8; i < count && asked < 64; i++) outputs[asked++] = atoi(words[i]);

    double begin = now();
    Instance own = fmi3InstantiateCoSimulation("own", words[2], words[3], 0, 0, 0, 0, NULL, 0, NULL, say, NULL);
    if (!own || fmi3EnterInitializationMode(own, 0, 0, 0, 0, 0) || fmi3ExitInitializationMode(own)) return 1;
    const double made = now() - begin;

    float *times = malloc(steps * sizeof *times);
    double values[64], torque;
    fmi3GetFloat64(own, &input, 1, &torque, 1);
    memset(times, 0, steps * sizeof *times);
    bool event, end, early;
    double last;
    unsigned long before = 0;
    for (long k = 0; k < steps; k++) {
        if (k == 1) before = allocations;
        const double start = now();
        int status = fmi3SetFloat64(own, &input, 1, &torque, 1);
        status |= fmi3DoStep(own, k * step, step, true, &event, &end, &early, &last);
        status |= fmi3GetFloat64(own, outputs, asked, values, asked);
        times[k] = now() - start;
        if (status) return 1;
    }
    const unsigned long during = allocations - before;
    int64_t met = 0;
    fmi3GetInt64(own, &events, 1, &met, 1);
    double sum = 0;
    for (long k = 0; k < steps; k++) sum += times[k];
    qsort(times, steps, sizeof *times, ascending);
    printf("{\"step\": %g, \"steps\": %ld, \"made\": %.4g, \"mean\": %.4g, \"median\": %.4g, \"p9999\": %.4g, \"worst\": %.4g, "
           "\"events\": %ld, \"allocations\": %lu}\n",
           step, steps, made, sum / steps, times[steps / 2], times[steps - 1 - steps / 10000], times[steps - 1], (long)met, during);
    fmi3Terminate(own);
    fmi3FreeInstance(own);
    return 0;
}
