/* Faults at the n-th call by which a process changes files below one folder.
 *
 * Loaded before the C library (LD_PRELOAD); armed by arm(). Calls are counted where they open for writing,
 * write, sync, rename, link, delete, cut or make a folder, and where the file lies below the folder.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum { COUNT, FAIL, FAIL_FROM_HERE, KILL, INTERRUPT };

static char root[PATH_MAX], journal[PATH_MAX];
static int mode = -1, number, fault, calls;

/* What a loss of power may take back is written to a journal: W path, then S path once it is synced. */
void arm(const char *folder, const char *journal_path, int what, int at, int error) {
    strncpy(root, folder, PATH_MAX - 1);
    strncpy(journal, journal_path, PATH_MAX - 1);
    mode = what; number = at; fault = error; calls = 0;
}

int counted(void) { return calls; }

static void *next(const char *name) { return dlsym(RTLD_NEXT, name); }

static void note(char kind, const char *path) {
    static int (*raw_open)(const char *, int, ...);
    static ssize_t (*raw_write)(int, const void *, size_t);
    char line[PATH_MAX + 64];
    struct stat status;
    int descriptor, saved = errno;
    if (!journal[0]) return;
    if (!raw_open) raw_open = next("open");
    if (!raw_write) raw_write = next("write");
    if (stat(path, &status)) status.st_size = 0;
    int size = snprintf(line, sizeof line, "%c %lld %s\n", kind, (long long)status.st_size, path);
    descriptor = raw_open(journal, O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (descriptor >= 0) { (void)!raw_write(descriptor, line, size); close(descriptor); }
    errno = saved;
}

static int below(const char *path) { return mode >= 0 && root[0] && path && !strncmp(path, root, strlen(root)); }

static int full_path(int folder, const char *path, char *full) {
    char link[64], base[PATH_MAX];
    if (path && path[0] == '/') { snprintf(full, PATH_MAX, "%s", path); return 1; }
    ssize_t size;
    if (folder == AT_FDCWD) { if (!getcwd(base, sizeof base)) return 0; }
    else {
        snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
        size = readlink(link, base, sizeof base - 1);
        if (size < 0) return 0;
        base[size] = 0;
    }
    if (path) snprintf(full, PATH_MAX, "%.2000s/%.2000s", base, path); else snprintf(full, PATH_MAX, "%s", base);
    return 1;
}

/* Whether this call is to fail; it does not return where the process is to be killed. */
static int hit(int folder, const char *path, char *full) {
    if (mode < 0 || !root[0]) return 0;
    int saved = errno;
    if (!full_path(folder, path, full) || !below(full)) { full[0] = 0; errno = saved; return 0; }
    errno = saved;
    calls++;
    if (calls == number && mode == KILL) kill(getpid(), SIGKILL);
    if (calls == number && mode == INTERRUPT) raise(SIGINT);
    if ((calls == number && mode == FAIL) || (calls >= number && mode == FAIL_FROM_HERE)) {
        errno = fault;
        return 1;
    }
    return 0;
}

#define WRITING(flags) ((flags) & (O_WRONLY | O_RDWR | O_CREAT | O_TRUNC))

#define OPEN(name)                                                                                   \
    int name(const char *path, int flags, ...) {                                                     \
        static int (*real)(const char *, int, ...);                                                  \
        va_list rest; char full[PATH_MAX] = "";                                                      \
        if (!real) real = next(#name);                                                               \
        va_start(rest, flags); mode_t access = va_arg(rest, int); va_end(rest);                      \
        if (WRITING(flags) && hit(AT_FDCWD, path, full)) return -1;                                  \
        return real(path, flags, access);                                                            \
    }
OPEN(open) OPEN(open64)

#define OPENAT(name)                                                                                 \
    int name(int folder, const char *path, int flags, ...) {                                         \
        static int (*real)(int, const char *, int, ...);                                             \
        va_list rest; char full[PATH_MAX] = "";                                                      \
        if (!real) real = next(#name);                                                               \
        va_start(rest, flags); mode_t access = va_arg(rest, int); va_end(rest);                      \
        if (WRITING(flags) && hit(folder, path, full)) return -1;                                    \
        return real(folder, path, flags, access);                                                    \
    }
OPENAT(openat) OPENAT(openat64)

/* A disk that fills up takes a part of what it is given. */
#define WRITE(name, parameters, arguments, fewer)                                                    \
    ssize_t name parameters {                                                                        \
        static ssize_t (*real) parameters;                                                           \
        char full[PATH_MAX] = "";                                                                    \
        if (!real) real = next(#name);                                                               \
        if (hit(descriptor, NULL, full)) { if (size > 1) { (void)!real fewer; } errno = fault; return -1; } \
        if (full[0]) note('W', full);                                                                \
        return real arguments;                                                                       \
    }
WRITE(write, (int descriptor, const void *data, size_t size), (descriptor, data, size), (descriptor, data, size / 2))
WRITE(pwrite, (int descriptor, const void *data, size_t size, off_t at), (descriptor, data, size, at),
      (descriptor, data, size / 2, at))
WRITE(pwrite64, (int descriptor, const void *data, size_t size, off64_t at), (descriptor, data, size, at),
      (descriptor, data, size / 2, at))

#define ON_DESCRIPTOR(name, parameters, arguments, failed, then)                                     \
    int name parameters {                                                                            \
        static int (*real) parameters;                                                               \
        char full[PATH_MAX] = "";                                                                    \
        if (!real) real = next(#name);                                                               \
        if (hit(descriptor, NULL, full)) return failed;                                              \
        int result = real arguments;                                                                 \
        if (full[0] && result == 0) { then; }                                                        \
        return result;                                                                               \
    }
ON_DESCRIPTOR(fsync, (int descriptor), (descriptor), -1, note('S', full))
ON_DESCRIPTOR(fdatasync, (int descriptor), (descriptor), -1, note('S', full))
ON_DESCRIPTOR(ftruncate, (int descriptor, off_t size), (descriptor, size), -1, note('W', full))
ON_DESCRIPTOR(ftruncate64, (int descriptor, off64_t size), (descriptor, size), -1, note('W', full))
ON_DESCRIPTOR(posix_fallocate, (int descriptor, off_t at, off_t size), (descriptor, at, size), fault, note('W', full))
ON_DESCRIPTOR(posix_fallocate64, (int descriptor, off64_t at, off64_t size), (descriptor, at, size), fault, note('W', full))

static void moved(const char *from, const char *to) {
    char line[2 * PATH_MAX + 2];
    snprintf(line, sizeof line, "%s\t%s", from, to);
    note('M', line);
}

#define TWO(name)                                                                                    \
    int name(const char *from, const char *to) {                                                     \
        static int (*real)(const char *, const char *);                                              \
        char full[PATH_MAX] = "", source[PATH_MAX] = "";                                             \
        if (!real) real = next(#name);                                                               \
        if (hit(AT_FDCWD, to, full)) return -1;                                                      \
        int result = real(from, to);                                                                 \
        if (full[0] && result == 0 && full_path(AT_FDCWD, from, source)) moved(source, full);        \
        return result;                                                                               \
    }
TWO(rename) TWO(link)

#define ONE(name, parameters, arguments)                                                             \
    int name parameters {                                                                            \
        static int (*real) parameters;                                                               \
        char full[PATH_MAX] = "";                                                                    \
        if (!real) real = next(#name);                                                               \
        if (hit(AT_FDCWD, path, full)) return -1;                                                    \
        return real arguments;                                                                       \
    }
ONE(unlink, (const char *path), (path))
ONE(rmdir, (const char *path), (path))
ONE(mkdir, (const char *path, mode_t access), (path, access))
