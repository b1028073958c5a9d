/* Runs a command whose k-th access to a file fails, once.
 *
 *     io_fault REPORT FOLDERS WHOSE KIND K COMMAND...
 *
 * It counts the system calls of one KIND (open, read, write, sync, rename, folder, stat) on files below one of the
 * FOLDERS (separated by colons), of the COMMAND's own program (WHOSE: driver) or of all others that it starts (solver).
 * The K-th fails with "no space left on device", or "input/output error" where nothing is written; with K = 0 none
 * does. REPORT gets a line for each counted call, or for the one that failed, and one for what the command left: `left
 * a process`, `took too long`. The exit code is the command's.
 *
 * seccomp stops the system calls and ptrace changes them: replaced functions of the C library (LD_PRELOAD) would see
 * neither the renames of rustix, which calls the kernel itself, nor what the C library's own streams do.
 */

#define _GNU_SOURCE
#include <errno.h>
#include <limits.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* How long processes may go on after the command, and how long the command may take, s. */
enum { LAST_BREATH = 10, LIMIT = 180 };

/* What a call says of its file: an open file; a path; a path after the folder it starts from; two of one of these. */
enum file { FD, PATH, AT, TWO_PATHS, TWO_AT };

static const struct call {
    long number;
    const char *name, *kind;
    enum file file;
    int error;
} calls[] = {
    {SYS_open, "open", "open", PATH, EIO},
    {SYS_openat, "openat", "open", AT, EIO},
    {SYS_creat, "creat", "open", PATH, ENOSPC},
    {SYS_read, "read", "read", FD, EIO},
    {SYS_pread64, "pread", "read", FD, EIO},
    {SYS_readv, "readv", "read", FD, EIO},
    {SYS_preadv, "preadv", "read", FD, EIO},
    {SYS_getdents64, "getdents", "read", FD, EIO},
    {SYS_write, "write", "write", FD, ENOSPC},
    {SYS_pwrite64, "pwrite", "write", FD, ENOSPC},
    {SYS_writev, "writev", "write", FD, ENOSPC},
    {SYS_pwritev, "pwritev", "write", FD, ENOSPC},
    {SYS_sendfile, "sendfile", "write", FD, ENOSPC},
    {SYS_copy_file_range, "copy_file_range", "read", FD, EIO},
    {SYS_ftruncate, "ftruncate", "write", FD, EIO},
    {SYS_truncate, "truncate", "write", PATH, EIO},
    {SYS_fsync, "fsync", "sync", FD, ENOSPC},
    {SYS_fdatasync, "fdatasync", "sync", FD, ENOSPC},
    {SYS_sync_file_range, "sync_file_range", "sync", FD, ENOSPC},
    {SYS_rename, "rename", "rename", TWO_PATHS, ENOSPC},
    {SYS_renameat, "renameat", "rename", TWO_AT, ENOSPC},
    {SYS_renameat2, "renameat2", "rename", TWO_AT, ENOSPC},
    {SYS_link, "link", "rename", TWO_PATHS, ENOSPC},
    {SYS_linkat, "linkat", "rename", TWO_AT, ENOSPC},
    {SYS_mkdir, "mkdir", "folder", PATH, ENOSPC},
    {SYS_mkdirat, "mkdirat", "folder", AT, ENOSPC},
    {SYS_rmdir, "rmdir", "folder", PATH, EIO},
    {SYS_unlink, "unlink", "folder", PATH, EIO},
    {SYS_unlinkat, "unlinkat", "folder", AT, EIO},
    {SYS_chmod, "chmod", "folder", PATH, EIO},
    {SYS_fchmod, "fchmod", "folder", FD, EIO},
    {SYS_stat, "stat", "stat", PATH, EIO},
    {SYS_lstat, "lstat", "stat", PATH, EIO},
    {SYS_fstat, "fstat", "stat", FD, EIO},
    {SYS_newfstatat, "newfstatat", "stat", AT, EIO},
    {SYS_statx, "statx", "stat", AT, EIO},
};
enum { CALLS = sizeof calls / sizeof *calls };

static const char *folders, *whose, *kind;
static long failing, counted;
static FILE *report;
static char own_program[PATH_MAX];

static void die(const char *what) {
    perror(what);
    exit(125);
}

/* Of /proc/PROCESS/WHAT; empty if it leads nowhere. */
static void link_of(pid_t process, const char *what, char target[PATH_MAX]) {
    char name[64];
    snprintf(name, sizeof name, "/proc/%d/%s", process, what);
    ssize_t length = readlink(name, target, PATH_MAX - 1);
    target[length < 0 ? 0 : length] = 0;
}

static void link_of_fd(pid_t process, int fd, char target[PATH_MAX]) {
    char name[32];
    snprintf(name, sizeof name, "fd/%d", fd);
    link_of(process, name, target);
}

/* The path at an address in the process, as seen from the folder `from` (an open file, or its working folder). */
static void path_at(pid_t process, unsigned long long address, int from, char path[PATH_MAX]) {
    static char text[PATH_MAX];
    memset(text, 0, sizeof text);
    /* In two parts: a path may stand at the end of the memory. */
    size_t first = 4096 - address % 4096;
    struct iovec here = {text, sizeof text - 1}, there[2] = {{(void *)address, first}, {(void *)(address + first), 4096}};
    process_vm_readv(process, &here, 1, there, 2, 0);
    path[0] = 0;
    if (text[0] != '/') {
        if (from == -100)
            link_of(process, "cwd", path);
        else
            link_of_fd(process, from, path);
        if (text[0])
            strncat(path, "/", PATH_MAX - 1 - strlen(path));
    }
    strncat(path, text, PATH_MAX - 1 - strlen(path));
}

static int is_below_folders(const char *path) {
    for (const char *folder = folders; *folder;) {
        size_t length = strcspn(folder, ":");
        if (!strncmp(path, folder, length) && (path[length] == '/' || !path[length]))
            return 1;
        folder += length + (folder[length] == ':');
    }
    return 0;
}

/* Whether the process runs the program that is watched. */
static int is_watched(pid_t process) {
    char program[PATH_MAX];
    link_of(process, "exe", program);
    return !strcmp(whose, "driver") == !strcmp(program, own_program);
}

/* Counts the call at which the process stands, and makes it fail if it is its turn. */
static void judge(pid_t process) {
    struct user_regs_struct registers;
    if (ptrace(PTRACE_GETREGS, process, 0, &registers))
        return;
    const struct call *call = calls;
    while (call < calls + CALLS && call->number != (long)registers.orig_rax)
        call++;
    if (call == calls + CALLS || strcmp(call->kind, kind))
        return;
    char path[PATH_MAX], other[PATH_MAX] = "";
    switch (call->file) {
    case FD:
        link_of_fd(process, (int)registers.rdi, path);
        break;
    case PATH:
        path_at(process, registers.rdi, -100, path);
        break;
    case AT:
        path_at(process, registers.rsi, (int)registers.rdi, path);
        break;
    case TWO_PATHS:
        path_at(process, registers.rdi, -100, path);
        path_at(process, registers.rsi, -100, other);
        break;
    case TWO_AT:
        path_at(process, registers.rsi, (int)registers.rdi, path);
        path_at(process, registers.r10, (int)registers.rdx, other);
        break;
    }
    if (!(is_below_folders(path) || is_below_folders(other)) || !is_watched(process))
        return;
    counted++;
    if (failing && failing != counted)
        return;
    fprintf(report, "%ld %s %s %s\n", counted, call->name, path, other);
    fflush(report);
    if (failing) {
        registers.orig_rax = -1ULL;
        registers.rax = (unsigned long long)-call->error;
        ptrace(PTRACE_SETREGS, process, 0, &registers);
    }
}

/* From here on the calls of this process, and of those that it starts, stop at the tracer. */
static void stop_at_calls(void) {
    struct sock_filter filter[CALLS + 6];
    int n = 0;
    filter[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, arch));
    filter[n++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 0, CALLS + 1);
    filter[n++] = (struct sock_filter)BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr));
    for (int i = 0; i < CALLS; i++)
        filter[n++] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, calls[i].number, CALLS - i, 0);
    filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    filter[n++] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRACE);
    struct sock_fprog program = {n, filter};
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program))
        die("seccomp");
}

/* Ends a wait. */
static void ring(int signal) { (void)signal; }

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec + 1e-9 * time.tv_nsec;
}

int main(int count, char **words) {
    if (count < 7) {
        fprintf(stderr, "io_fault REPORT FOLDERS WHOSE KIND K COMMAND...\n");
        return 125;
    }
    report = fopen(words[1], "we");
    if (!report)
        die(words[1]);
    folders = words[2], whose = words[3], kind = words[4], failing = atol(words[5]);
    if (!realpath(words[6], own_program))
        die(words[6]);

    pid_t command = fork();
    if (command < 0)
        die("fork");
    if (!command) {
        if (ptrace(PTRACE_TRACEME, 0, 0, 0))
            die("ptrace");
        raise(SIGSTOP);
        stop_at_calls();
        execv(own_program, words + 6);
        die(own_program);
    }
    int status, code = 125;
    waitpid(command, &status, 0);
    long options = PTRACE_O_TRACESECCOMP | PTRACE_O_TRACEFORK | PTRACE_O_TRACEVFORK | PTRACE_O_TRACECLONE |
                   PTRACE_O_TRACEEXEC | PTRACE_O_EXITKILL;
    if (ptrace(PTRACE_SETOPTIONS, command, 0, options))
        die("ptrace");
    ptrace(PTRACE_CONT, command, 0, 0);

    struct sigaction bell = {.sa_handler = ring};
    sigaction(SIGALRM, &bell, 0);
    alarm(LIMIT);
    double end = 0;
    int ended = 0;
    for (;;) {
        /* Sleeping would cost a millisecond a call. */
        pid_t process = waitpid(-1, &status, __WALL | (ended ? WNOHANG : 0));
        if (process < 0 && errno == EINTR)
            fprintf(report, "took too long\n");
        if (process < 0)
            break;
        if (process == 0) {
            if (now() > end) {
                fprintf(report, "left a process\n");
                break; /* which kills it */
            }
            usleep(2000);
            continue;
        }
        if (!WIFSTOPPED(status)) {
            if (process == command) {
                code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
                ended = 1, end = now() + LAST_BREATH;
                alarm(0);
            }
            continue;
        }
        int signal = WSTOPSIG(status), event = status >> 16;
        if (event == PTRACE_EVENT_SECCOMP)
            judge(process);
        /* What has just been started begins with a stop. */
        ptrace(PTRACE_CONT, process, 0, event || signal == SIGSTOP ? 0 : signal);
    }
    fclose(report);
    return code;
}
