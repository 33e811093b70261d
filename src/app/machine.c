// SPDX-License-Identifier: Apache-2.0
// The command's own needs of the machine that the library has no use for: terminals and signals.
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/print.h"

static volatile sig_atomic_t interrupted;

static void note_interrupt(int number)
{
    if (interrupted != 0) { // the second one has its default effect once this handler has returned
        signal(number, SIG_DFL);
        raise(number);
    }
    interrupted = 1;
}

void clast_watch_interrupts(void)
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = note_interrupt;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    signal(SIGXFSZ, SIG_IGN); // a file that may not grow is then an error, as on a full disk
}

bool clast_interrupted(void)
{
    return interrupted != 0;
}

bool clast_is_terminal(FILE *stream)
{
    return isatty(fileno(stream)) == 1;
}

// The folder of a path must take a new file, which is renamed when whole; a device is written to as it is.
bool clast_can_write(const char *path)
{
    struct stat about;
    char real[PATH_MAX]; // behind links
    if (realpath(path, real) != NULL) {
        path = real;
    }
    if (stat(path, &about) == 0 && !S_ISREG(about.st_mode)) {
        return !S_ISDIR(about.st_mode) && access(path, W_OK) == 0;
    }
    char folder[PATH_MAX] = ".";
    const char *slash = strrchr(path, '/');
    if (slash != NULL) {
        size_t length = slash == path ? 1 : (size_t)(slash - path);
        if (length >= sizeof folder) {
            return false;
        }
        memcpy(folder, path, length);
        folder[length] = '\0';
    }
    return access(folder, W_OK | X_OK) == 0 && stat(folder, &about) == 0 && S_ISDIR(about.st_mode);
}
