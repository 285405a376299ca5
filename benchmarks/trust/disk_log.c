/* Logs what a process asks of the files below a folder, for benchmarks/trust/power.py.
 *
 * gcc -shared -fPIC -O1 disk_log.c -o disk_log.so -ldl; then with LD_PRELOAD, TRUST_LOG (the file of
 * the log) and TRUST_FOLDER. Records: a letter, three 64-bit numbers a b n, and n bytes.
 *   O file opened: a descriptor, b flags, bytes the path     W written: a descriptor, b offset
 *   T cut: a descriptor, b length                            S synced: a descriptor
 *   U path removed      R renamed: both paths, a zero between      C what went to standard output
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

#define MOST 65536
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static char followed[MOST];
static int log_fd = -2;
static const char *folder;

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static void put(const void *data, size_t n) {
  static __typeof__(&write) real;
  if (!real) real = REAL(write);
  for (const char *p = data; n > 0;) {
    ssize_t k = real(log_fd, p, n);
    if (k <= 0) abort();
    p += k, n -= (size_t)k;
  }
}

static int ready(void) {
  if (log_fd == -2) {
    const char *name = getenv("TRUST_LOG");
    folder = getenv("TRUST_FOLDER");
    log_fd = name && folder ? REAL(open)(name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600) : -1;
  }
  return log_fd >= 0;
}

static void record(char kind, int64_t a, int64_t b, const void *data, int64_t n) {
  int64_t numbers[3] = {a, b, n};
  pthread_mutex_lock(&lock);
  put(&kind, 1);
  put(numbers, sizeof numbers);
  put(data, (size_t)n);
  pthread_mutex_unlock(&lock);
}

static int inside(const char *path) {
  return ready() && !strncmp(path, folder, strlen(folder));
}
static int known(int fd) { return fd >= 0 && fd < MOST && followed[fd] && ready(); }

static int opened(int fd, const char *path, int flags) {
  if (fd >= 0 && fd < MOST) {
    followed[fd] = inside(path);
    if (followed[fd]) record('O', fd, flags, path, (int64_t)strlen(path));
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
    if (done > 0 && known(fd)) record('W', fd, (int64_t)offset, data, done); \
    return done;                                                        \
  }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

ssize_t write(int fd, const void *data, size_t n) {
  off_t offset = known(fd) ? lseek(fd, 0, SEEK_CUR) : 0;
  ssize_t done = REAL(write)(fd, data, n);
  if (done > 0 && fd == 1 && ready()) record('C', 0, 0, data, done);
  if (done > 0 && known(fd)) record('W', fd, offset, data, done);
  return done;
}

#define CUT(name, offset_t)                                   \
  int name(int fd, offset_t length) {                         \
    int failed = REAL(name)(fd, length);                      \
    if (!failed && known(fd)) record('T', fd, length, "", 0); \
    return failed;                                            \
  }
CUT(ftruncate, off_t)
CUT(ftruncate64, off64_t)

#define SYNC(name)                                        \
  int name(int fd) {                                      \
    int failed = REAL(name)(fd);                          \
    if (!failed && known(fd)) record('S', fd, 0, "", 0);  \
    return failed;                                        \
  }
SYNC(fsync)
SYNC(fdatasync)

int unlink(const char *path) {
  int failed = REAL(unlink)(path);
  if (!failed && inside(path)) record('U', 0, 0, path, (int64_t)strlen(path));
  return failed;
}

int rename(const char *from, const char *to) {
  int failed = REAL(rename)(from, to);
  if (!failed && inside(from)) {
    size_t a = strlen(from), b = strlen(to);
    char *both = malloc(a + b + 2);
    memcpy(both, from, a + 1);
    memcpy(both + a + 1, to, b);
    record('R', 0, 0, both, (int64_t)(a + b + 1));
    free(both);
  }
  return failed;
}

int close(int fd) {
  if (fd >= 0 && fd < MOST) followed[fd] = 0;
  return REAL(close)(fd);
}
