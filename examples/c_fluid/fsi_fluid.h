/* A flow solver in C as the fluid of fsi-driver: the fluid's side of of-adapter/PROTOCOL.md, version 3.

   Fill a `struct fsi_fluid` with what the solver knows and call `fsi_serve`, which returns the exit code of the process:

       int main(void) { struct fsi_fluid fluid = {...}; return fsi_serve(&fluid); }

   C99 and POSIX, little-endian machines, sockets (fluid.transport = "socket"). All quantities are in SI units; vectors are
   three doubles one after the other. */

#ifndef FSI_FLUID_H
#define FSI_FLUID_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#define FSI_VERSION 3
#define FSI_LONGEST_TEXT 4096
#define FSI_LONGEST_STATE (1u << 28)

/* Where the fluid enters or leaves its domain; the inlet is the first one. */
struct fsi_opening {
    const char *name;
    int has_model;         /* whether a model with a pressure of its own stands behind it */
    double flow;           /* into the domain, m3/s: set by accept */
    double mean_pressure;  /* Pa: likewise */
    double model_pressure; /* Pa: likewise, 0 without a model */
};

/* A solver. Functions return 0, or -1 after they have put the reason into `error`. */
struct fsi_fluid {
    void *own; /* the solver's own data */

    /* The wet surface in the reference configuration, the same at every start. By the right-hand rule the normal of a
       face points out of the fluid. */
    uint32_t points, faces;
    const double *positions;  /* 3 a point, m */
    const uint32_t *sizes;    /* vertices of each face */
    const uint32_t *vertices; /* of all faces, one after the other */
    const double *centres;    /* 3 a face, m */

    uint32_t openings;
    struct fsi_opening *opening;
    double volume;       /* of the whole domain now, m3; accept keeps it up to date */
    double rigid_volume; /* of the part of it whose wall is rigid, m3 */

    /* Solve the current time step from the old state for the displacement of the points at its end; write the load on
       the faces, `p n` less the viscous stress, Pa. It is called again and again until accept. */
    int (*solve)(struct fsi_fluid *, const double *displacement, double time_step, int from_old_state, double *tractions);
    /* Keep the last trial; write the viscous part of the load. */
    int (*accept)(struct fsi_fluid *, double *wall_shear);
    /* Bytes with which `restore` can go on from the last accepted step; they stay the solver's. */
    int (*state)(struct fsi_fluid *, const void **bytes, uint64_t *length);
    int (*restore)(struct fsi_fluid *, const void *bytes, uint64_t length);
    /* A state is not needed any more; may be null. */
    void (*discard)(struct fsi_fluid *, const void *bytes, uint64_t length);

    char error[256];
};

enum {
    FSI_HELLO = 1, FSI_WELCOME, FSI_SOLVE, FSI_SOLVED, FSI_ACCEPT, FSI_ACCEPTED, FSI_STOP, FSI_FAILURE, FSI_DISCARD
};

/* Bytes that grow. */
struct fsi_bytes {
    unsigned char *at;
    size_t length, room;
};

static void fsi_put(struct fsi_bytes *bytes, const void *more, size_t length)
{
    if (bytes->length + length > bytes->room) {
        bytes->room = 2 * (bytes->length + length);
        bytes->at = realloc(bytes->at, bytes->room);
        if (!bytes->at) abort();
    }
    if (length) memcpy(bytes->at + bytes->length, more, length);
    bytes->length += length;
}

static void fsi_put_u32(struct fsi_bytes *bytes, uint32_t value) { fsi_put(bytes, &value, 4); }
static void fsi_put_f64(struct fsi_bytes *bytes, double value) { fsi_put(bytes, &value, 8); }

static int fsi_all_finite(const double *values, size_t n)
{
    while (n--) if (!isfinite(values[n])) return 0;
    return 1;
}

static int fsi_send(int line, uint16_t kind, const struct fsi_bytes *payload)
{
    struct fsi_bytes message = {0};
    uint16_t version = FSI_VERSION;
    uint64_t length = payload ? payload->length : 0;
    fsi_put(&message, "FSIP", 4);
    fsi_put(&message, &version, 2);
    fsi_put(&message, &kind, 2);
    fsi_put(&message, &length, 8);
    if (length) fsi_put(&message, payload->at, length);
    size_t sent = 0;
    while (sent < message.length) {
        ssize_t n = send(line, message.at + sent, message.length - sent, MSG_NOSIGNAL);
        if (n <= 0) break;
        sent += (size_t)n;
    }
    int done = sent == message.length;
    free(message.at);
    return done ? 0 : -1;
}

static int fsi_read(int line, void *bytes, size_t length)
{
    for (size_t done = 0; done < length;) {
        ssize_t n = read(line, (char *)bytes + done, length - done);
        if (n <= 0) return -1;
        done += (size_t)n;
    }
    return 0;
}

/* Tells the driver and the log why this process ends. */
static int fsi_fail(int line, const char *why)
{
    struct fsi_bytes text = {0};
    size_t length = strlen(why);
    fsi_put(&text, why, length < FSI_LONGEST_TEXT ? length : FSI_LONGEST_TEXT);
    if (line >= 0) fsi_send(line, FSI_FAILURE, &text);
    free(text.at);
    fprintf(stderr, "fsi_fluid: %s\n", why);
    return 1;
}

/* The next message, whose kind is in the set of bits `allowed`, with so many bytes (from - to) if it is `kind` ... */
static int fsi_receive(int line, unsigned allowed, uint64_t solve_length, uint16_t *kind, struct fsi_bytes *payload, char *why)
{
    unsigned char head[16];
    uint16_t version;
    uint64_t length;
    if (fsi_read(line, head, 16)) return strcpy(why, "the driver has closed the connection"), -1;
    if (memcmp(head, "FSIP", 4)) return strcpy(why, "the driver sent bytes that are not a message"), -1;
    memcpy(&version, head + 4, 2);
    memcpy(kind, head + 6, 2);
    memcpy(&length, head + 8, 8);
    if (version != FSI_VERSION)
        return sprintf(why, "the driver speaks protocol version %u, this fluid speaks %u", version, FSI_VERSION), -1;
    if (*kind < 1 || *kind > 9) return sprintf(why, "the driver sent a message of unknown kind %u", *kind), -1;
    if (*kind != FSI_FAILURE && !(allowed >> *kind & 1))
        return sprintf(why, "the driver sent a message of kind %u, which does not belong here", *kind), -1;
    uint64_t least = 0, most = 0;
    switch (*kind) {
    case FSI_WELCOME: least = 24; most = 24 + (uint64_t)FSI_LONGEST_STATE; break;
    case FSI_SOLVE: least = most = solve_length; break;
    case FSI_ACCEPT: least = most = 4; break;
    case FSI_DISCARD: most = FSI_LONGEST_STATE; break;
    case FSI_FAILURE: most = FSI_LONGEST_TEXT; break;
    }
    if (length < least || length > most)
        return sprintf(why, "the driver's message of kind %u has %llu bytes, expected %llu to %llu", *kind,
                       (unsigned long long)length, (unsigned long long)least, (unsigned long long)most), -1;
    payload->length = 0;
    while (payload->length < length) { /* in pieces: an announced length alone reserves nothing */
        unsigned char piece[1 << 16];
        size_t n = length - payload->length < sizeof piece ? (size_t)(length - payload->length) : sizeof piece;
        if (fsi_read(line, piece, n)) return strcpy(why, "the driver has closed the connection"), -1;
        fsi_put(payload, piece, n);
    }
    if (*kind == FSI_FAILURE) return snprintf(why, 512, "the driver ended: %.*s", (int)payload->length, payload->at), -1;
    return 0;
}

/* What the driver tells in the environment; ends the process if it does not. */
static const char *fsi_told(const char *name)
{
    const char *value = getenv(name);
    if (!value) {
        fprintf(stderr, "%s is not set: this program is started by fsi-driver (fluid.command)\n", name);
        exit(2);
    }
    return value;
}

static int fsi_serve(struct fsi_fluid *fluid)
{
    char why[1024] = "";
    double start = strtod(fsi_told("FSI_START_TIME_S"), NULL), step = strtod(fsi_told("FSI_TIME_STEP_S"), NULL);
    const char *address = fsi_told("FSI_ADDRESS");
    struct sockaddr_un there = {.sun_family = AF_UNIX};
    int line = socket(AF_UNIX, SOCK_STREAM, 0);
    if (strcmp(fsi_told("FSI_TRANSPORT"), "socket")) return fsi_fail(-1, "this fluid needs fluid.transport = \"socket\"");
    if (strlen(address) >= sizeof there.sun_path) return fsi_fail(-1, "the address of the driver is too long");
    strcpy(there.sun_path, address);
    if (line < 0 || connect(line, (struct sockaddr *)&there, sizeof there)) return fsi_fail(-1, "cannot reach the driver");

    struct fsi_bytes out = {0}, in = {0};
    uint32_t vertices = 0;
    for (uint32_t i = 0; i < fluid->faces; ++i) vertices += fluid->sizes[i];
    const double numbers[4] = {start, step, fluid->volume, fluid->rigid_volume};
    const uint32_t counts[4] = {fluid->points, fluid->faces, vertices, fluid->openings};
    fsi_put(&out, numbers, sizeof numbers);
    fsi_put(&out, counts, sizeof counts);
    fsi_put(&out, fluid->positions, 24ul * fluid->points);
    fsi_put(&out, fluid->sizes, 4ul * fluid->faces);
    fsi_put(&out, fluid->vertices, 4ul * vertices);
    fsi_put(&out, fluid->centres, 24ul * fluid->faces);
    for (uint32_t i = 0; i < fluid->openings; ++i) {
        uint32_t length = (uint32_t)strlen(fluid->opening[i].name);
        fsi_put_u32(&out, fluid->opening[i].has_model ? 1 : 0);
        fsi_put_u32(&out, length);
        fsi_put(&out, fluid->opening[i].name, length);
    }
    uint16_t kind;
    const uint64_t solve_length = 24 + 24ul * fluid->points;
    if (fsi_send(line, FSI_HELLO, &out)) return fsi_fail(line, "cannot write to the driver");
    if (fsi_receive(line, 1u << FSI_WELCOME, solve_length, &kind, &in, why)) return fsi_fail(line, why);
    double its[2];
    uint32_t counted[2];
    memcpy(its, in.at, 16);
    memcpy(counted, in.at + 16, 8);
    if (!(fabs(its[0] - start) <= 1e-6 * step) || !(fabs(its[1] - step) <= 1e-9 * step) || counted[0] != fluid->points ||
        counted[1] != fluid->faces)
        return fsi_fail(line, "driver and fluid do not fit: other times, or another wall");
    if (in.length > 24 && fluid->restore(fluid, in.at + 24, in.length - 24)) return fsi_fail(line, fluid->error);

    double now = start, open = 0; /* length of the open step; 0 between steps */
    double *tractions = calloc(3ul * fluid->faces, sizeof *tractions);
    double *displacement = calloc(3ul * fluid->points, sizeof *displacement);
    if (!tractions || !displacement) return fsi_fail(line, "no memory");
    for (;;) {
        unsigned allowed = 1u << FSI_SOLVE | 1u << FSI_STOP | 1u << FSI_DISCARD | (open > 0 ? 1u << FSI_ACCEPT : 0);
        if (fsi_receive(line, allowed, solve_length, &kind, &in, why)) return fsi_fail(line, why);
        out.length = 0;
        uint32_t flags;
        if (kind == FSI_STOP) break;
        if (kind == FSI_DISCARD) {
            if (fluid->discard) fluid->discard(fluid, in.at, in.length);
        } else if (kind == FSI_SOLVE) {
            uint32_t correctors;
            double limits[2];
            memcpy(&correctors, in.at, 4);
            memcpy(&flags, in.at + 4, 4);
            memcpy(limits, in.at + 8, 16);
            memcpy(displacement, in.at + 24, 24ul * fluid->points);
            if (!correctors || flags > 1 || !isfinite(limits[0]) || !(limits[1] > 0) || !isfinite(limits[1]))
                return fsi_fail(line, "SOLVE with numbers that make no sense");
            if (!fsi_all_finite(displacement, 3ul * fluid->points))
                return fsi_fail(line, "SOLVE with a displacement that is not finite");
            if (open > 0 && open != limits[1] && !flags)
                return fsi_fail(line, "an open time step changed its length without going back to its beginning");
            open = limits[1];
            if (fluid->solve(fluid, displacement, open, (int)flags, tractions)) return fsi_fail(line, fluid->error);
            fsi_put_u32(&out, 1);
            fsi_put_u32(&out, 0);
            fsi_put_f64(&out, now + open);
            fsi_put_f64(&out, 0);
            fsi_put(&out, tractions, 24ul * fluid->faces);
            if (fsi_send(line, FSI_SOLVED, &out)) return fsi_fail(line, "cannot write to the driver");
        } else {
            memcpy(&flags, in.at, 4);
            if (flags > 1) return fsi_fail(line, "ACCEPT with unknown flags");
            now += open;
            open = 0;
            if (fluid->accept(fluid, tractions)) return fsi_fail(line, fluid->error);
            fsi_put_f64(&out, now);
            fsi_put_f64(&out, fluid->volume);
            fsi_put_f64(&out, 0);
            for (uint32_t i = 0; i < fluid->openings; ++i) {
                fsi_put_f64(&out, fluid->opening[i].flow);
                fsi_put_f64(&out, fluid->opening[i].mean_pressure);
                fsi_put_f64(&out, fluid->opening[i].model_pressure);
            }
            fsi_put(&out, tractions, 24ul * fluid->faces);
            if (flags) {
                const void *state;
                uint64_t length;
                if (fluid->state(fluid, &state, &length)) return fsi_fail(line, fluid->error);
                fsi_put(&out, state, length);
            }
            if (fsi_send(line, FSI_ACCEPTED, &out)) return fsi_fail(line, "cannot write to the driver");
        }
    }
    free(out.at);
    free(in.at);
    free(tractions);
    free(displacement);
    close(line);
    return 0;
}

#endif
