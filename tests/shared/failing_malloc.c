/* Preloaded: of the allocations of one library, that of a given number fails, once. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stddef.h>

static atomic_long until, counted;
static char *low, *high;

/* The addresses of the library's code. */
void watch(char *begin, char *end) {
    low = begin;
    high = end;
}

/* Counts from 1 on; the allocation `number` fails, none if it is 0. */
void fail_allocation(long number) {
    atomic_store(&counted, 0);
    atomic_store(&until, number);
}

long allocations(void) { return atomic_load(&counted); }

static int fails(char *caller) {
    if (caller < low || caller >= high) return 0;
    return atomic_fetch_add(&counted, 1) + 1 == atomic_load(&until);
}

#define FAILS fails(__builtin_return_address(0))

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);

void *malloc(size_t size) { return FAILS ? (errno = ENOMEM, NULL) : __libc_malloc(size); }

void *calloc(size_t count, size_t size) { return FAILS ? (errno = ENOMEM, NULL) : __libc_calloc(count, size); }

void *realloc(void *old, size_t size) { return FAILS ? (errno = ENOMEM, NULL) : __libc_realloc(old, size); }

int posix_memalign(void **to, size_t alignment, size_t size) {
    static int (*next)(void **, size_t, size_t);
    if (!next) next = (int (*)(void **, size_t, size_t))dlsym(RTLD_NEXT, "posix_memalign");
    return FAILS ? ENOMEM : next(to, alignment, size);
}
