/* Logs what processes ask of the files below a folder, for benchmarks/trust/power.py.
 *
 * gcc -shared -fPIC -O1 disk_log.c -o disk_log.so -ldl; then with LD_PRELOAD, TRUST_LOG (the file of
 * the log) and TRUST_FOLDER. Records: a letter, three 64-bit numbers a b n, and n bytes.
 *   O file opened: a descriptor, b flags, bytes the path     W written: a descriptor, b offset
 *   T cut: a descriptor, b length      P cut: b length, bytes the path
 *   F a sync begins: a descriptor      S it is done: a descriptor
 *   U path removed      R renamed, L named once more: both paths, a zero between
 *   C what went to standard output
 * A descriptor is that of the process which opened the file; a process forked off keeps it.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#define MOST 65536
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pid_t followed[MOST]; /* by whom it was opened */
static int log_fd = -2;
static const char *folder;

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int ready(void) {
  if (log_fd == -2) {
    const char *name = getenv("TRUST_LOG");
    folder = getenv("TRUST_FOLDER");
    log_fd = name && folder ? REAL(open)(name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600) : -1;
  }
  return log_fd >= 0;
}

/* One write to the end: what other processes log at the same time stands before or after it. */
static void record(char kind, int64_t a, int64_t b, const void *data, int64_t n) {
  int64_t numbers[3] = {a, b, n};
  struct iovec parts[3] = {{&kind, 1}, {numbers, sizeof numbers}, {(void *)data, (size_t)n}};
  pthread_mutex_lock(&lock);
  if (REAL(writev)(log_fd, parts, 3) != (ssize_t)(1 + sizeof numbers) + n) abort();
  pthread_mutex_unlock(&lock);
}

/* The path from the root; PostgreSQL names its files from its folder. */
static const char *whole(const char *path, char *into) {
  if (path[0] == '/' || !getcwd(into, PATH_MAX) || strlen(into) + strlen(path) + 2 > PATH_MAX) {
    return path;
  }
  return strcat(strcat(into, "/"), path);
}
static int inside(const char *path) {
  return ready() && !strncmp(path, folder, strlen(folder));
}
static int known(int fd) { return fd >= 0 && fd < MOST && followed[fd] && ready(); }
static int64_t key(int fd) { return ((int64_t)followed[fd] << 20) | fd; }

static int opened(int fd, const char *name, int flags) {
  if (fd >= 0 && fd < MOST) {
    char room[PATH_MAX];
    const char *path = whole(name, room);
    followed[fd] = inside(path) ? getpid() : 0;
    if (followed[fd]) record('O', key(fd), flags, path, (int64_t)strlen(path));
  }
  return fd;
}
#define OPEN(name)                                             \
  int name(const char *path, int flags, ...) {                 \
    va_list rest;                                              \
    va_start(rest, flags);                                     \
    mode_t mode = va_arg(rest, mode_t);                        \
    va_end(rest);                                              \
    return opened(REAL(name)(path, flags, mode), path, flags); \
  }
OPEN(open)
OPEN(open64)

#define PWRITE(name, offset_t)                                          \
  ssize_t name(int fd, const void *data, size_t n, offset_t offset) {   \
    ssize_t done = REAL(name)(fd, data, n, offset);                     \
    if (done > 0 && known(fd)) record('W', key(fd), (int64_t)offset, data, done); \
    return done;                                                        \
  }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

#define PWRITEV(name, offset_t)                                                    \
  ssize_t name(int fd, const struct iovec *parts, int n, offset_t offset) {        \
    ssize_t done = REAL(name)(fd, parts, n, offset);                               \
    if (done > 0 && known(fd)) {                                                   \
      char *whole = malloc((size_t)done);                                          \
      size_t at = 0;                                                               \
      for (int i = 0; i < n && at < (size_t)done; i++) {                           \
        size_t left = (size_t)done - at;                                           \
        size_t k = parts[i].iov_len < left ? parts[i].iov_len : left;              \
        memcpy(whole + at, parts[i].iov_base, k);                                  \
        at += k;                                                                   \
      }                                                                            \
      record('W', key(fd), (int64_t)offset, whole, done);                          \
      free(whole);                                                                 \
    }                                                                              \
    return done;                                                                   \
  }
PWRITEV(pwritev, off_t)
PWRITEV(pwritev64, off64_t)

ssize_t write(int fd, const void *data, size_t n) {
  off_t offset = known(fd) ? lseek(fd, 0, SEEK_CUR) : 0;
  ssize_t done = REAL(write)(fd, data, n);
  if (done > 0 && fd == 1 && ready()) record('C', 0, 0, data, done);
  if (done > 0 && known(fd)) record('W', key(fd), offset, data, done);
  return done;
}

#define CUT(name, offset_t)                                   \
  int name(int fd, offset_t length) {                         \
    int failed = REAL(name)(fd, length);                      \
    if (!failed && known(fd)) record('T', key(fd), length, "", 0); \
    return failed;                                            \
  }
CUT(ftruncate, off_t)
CUT(ftruncate64, off64_t)

int truncate(const char *name, off_t length) {
  char room[PATH_MAX];
  const char *path = whole(name, room);
  int failed = REAL(truncate)(name, length);
  if (!failed && inside(path)) record('P', 0, length, path, (int64_t)strlen(path));
  return failed;
}

#define SYNC(name)                                           \
  int name(int fd) {                                         \
    if (known(fd)) record('F', key(fd), 0, "", 0);           \
    int failed = REAL(name)(fd);                             \
    if (!failed && known(fd)) record('S', key(fd), 0, "", 0); \
    return failed;                                           \
  }
SYNC(fsync)
SYNC(fdatasync)

int unlink(const char *name) {
  char room[PATH_MAX];
  const char *path = whole(name, room);
  int failed = REAL(unlink)(name);
  if (!failed && inside(path)) record('U', 0, 0, path, (int64_t)strlen(path));
  return failed;
}

static void names(char kind, const char *old, const char *new) {
  char room[PATH_MAX], other[PATH_MAX], both[2 * PATH_MAX];
  const char *from = whole(old, room), *to = whole(new, other);
  if (!inside(from)) return;
  size_t a = strlen(from), b = strlen(to);
  memcpy(both, from, a + 1);
  memcpy(both + a + 1, to, b);
  record(kind, 0, 0, both, (int64_t)(a + b + 1));
}
#define NAME(name, kind)                       \
  int name(const char *from, const char *to) { \
    int failed = REAL(name)(from, to);         \
    if (!failed) names(kind, from, to);        \
    return failed;                             \
  }
NAME(rename, 'R')
NAME(link, 'L')

int close(int fd) {
  if (fd >= 0 && fd < MOST) followed[fd] = 0;
  return REAL(close)(fd);
}
