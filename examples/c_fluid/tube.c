/* Blood in one dimension, in C: a flow solver that couples to the wall of fsi-driver.

       cc -O2 -o tube examples/c_fluid/tube.c -lm
       fsi-driver --case openfoam-case/S-0.0 --preset demo \
           --set 'fluid.command=["./tube", "1050", "3.5e-3", "5.0e-6", "0.5", "1.785e9", "1.83e-10", "4.6e4"]'

   Arguments: density kg/m3, viscosity Pa s, flow at the inlet m3/s after a smooth start of so many s; resistance Pa s/m3,
   compliance m3/Pa and initial pressure Pa of the windkessel at the outlet.

   By implicit Euler, on the slices between the rings of the wall that fsi-driver proposes (FSI_WALL), along x:

       dA/dt + dQ/dx = 0,        rho dQ/dt + A dp/dx + 8 pi mu Q/A = 0

   The wall prescribes the areas A; Q follows from the inlet on, then p from the outlet back. */

#define _POSIX_C_SOURCE 200809L
#include "fsi_fluid.h"

#define PI 3.14159265358979323846

struct state {
    double time, model;   /* s; pressure of the windkessel, Pa */
    double numbers[];     /* area of each slice, m2; then the flow through its ends, m3/s */
};

struct tube {
    double rho, mu, inflow, ramp, resistance, compliance;
    uint32_t slices;
    uint32_t *slice_of;   /* of each face */
    double *lengths, *shear, *pressure;
    struct state *old, *trial;
    size_t size;          /* bytes of a state */
};

static double *area_of(const struct tube *tube, struct state *state) { (void)tube; return state->numbers; }
static double *flow_of(const struct tube *tube, struct state *state) { return state->numbers + tube->slices; }

/* Area vector and centre of a face of four points. */
static void shape(const struct fsi_fluid *fluid, const double *u, uint32_t face, double s[3], double c[3])
{
    double p[4][3];
    for (int k = 0; k < 4; ++k)
        for (int d = 0; d < 3; ++d) {
            uint32_t i = 3 * fluid->vertices[4 * face + k] + d;
            p[k][d] = fluid->positions[i] + (u ? u[i] : 0);
        }
    for (int d = 0; d < 3; ++d) {
        int e = (d + 1) % 3, f = (d + 2) % 3;
        s[d] = 0.5 * ((p[2][e] - p[0][e]) * (p[3][f] - p[1][f]) - (p[2][f] - p[0][f]) * (p[3][e] - p[1][e]));
        c[d] = 0.25 * (p[0][d] + p[1][d] + p[2][d] + p[3][d]);
    }
}

static void areas(const struct fsi_fluid *fluid, const double *u, double *area)
{
    const struct tube *tube = fluid->own;
    memset(area, 0, tube->slices * sizeof *area);
    for (uint32_t i = 0; i < fluid->faces; ++i) {
        double s[3], c[3];
        shape(fluid, u, i, s, c);
        area[tube->slice_of[i]] += 0.5 * (c[1] * s[1] + c[2] * s[2]) / tube->lengths[tube->slice_of[i]];
    }
}

static double volume(const struct tube *tube, const double *area)
{
    double sum = 0;
    for (uint32_t i = 0; i < tube->slices; ++i) sum += tube->lengths[i] * area[i];
    return sum;
}

static int solve(struct fsi_fluid *fluid, const double *u, double dt, int from_old_state, double *tractions)
{
    struct tube *tube = fluid->own;
    struct state *old = tube->old, *now = tube->trial;
    double *area = area_of(tube, now), *flow = flow_of(tube, now);
    const double *old_area = area_of(tube, old), *old_flow = flow_of(tube, old);
    uint32_t n = tube->slices;
    (void)from_old_state; /* it always does */
    areas(fluid, u, area);
    for (uint32_t i = 0; i < n; ++i)
        if (!(area[i] > 0)) return sprintf(fluid->error, "the tube has collapsed in slice %u", i), -1;
    now->time = old->time + dt;
    double share = now->time < tube->ramp ? 0.5 * (1 - cos(PI * now->time / tube->ramp)) : 1;
    flow[0] = share * tube->inflow;
    for (uint32_t i = 0; i < n; ++i) flow[i + 1] = flow[i] - tube->lengths[i] * (area[i] - old_area[i]) / dt;
    now->model = (old->model * tube->compliance / dt + flow[n]) / (tube->compliance / dt + 1 / tube->resistance);
    double behind = share * now->model;
    fluid->opening[1].mean_pressure = behind;
    for (uint32_t i = n; i-- > 0;) {
        double length = 0.5 * (tube->lengths[i] + (i + 1 < n ? tube->lengths[i + 1] : 0));
        double inertia = tube->rho * (flow[i + 1] - old_flow[i + 1]) / dt;
        behind += length * (inertia + 8 * PI * tube->mu * flow[i + 1] / area[i]) / area[i];
        tube->pressure[i] = behind;
    }
    fluid->opening[0].mean_pressure = behind;
    for (uint32_t i = 0; i < fluid->faces; ++i) {
        double s[3], c[3];
        uint32_t k = tube->slice_of[i];
        shape(fluid, u, i, s, c);
        double size = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
        double drag = 2 * tube->mu * (flow[k] + flow[k + 1]) / (PI * pow(area[k] / PI, 1.5));
        for (int d = 0; d < 3; ++d) {
            double normal = s[d] / size;
            tube->shear[3 * i + d] = drag * ((d == 0) - s[0] / size * normal);
            tractions[3 * i + d] = tube->pressure[k] * normal + tube->shear[3 * i + d];
        }
    }
    return 0;
}

static int accept_trial(struct fsi_fluid *fluid, double *wall_shear)
{
    struct tube *tube = fluid->own;
    memcpy(tube->old, tube->trial, tube->size);
    memcpy(wall_shear, tube->shear, 24ul * fluid->faces);
    fluid->opening[0].flow = flow_of(tube, tube->old)[0];
    fluid->opening[1].flow = -flow_of(tube, tube->old)[tube->slices];
    fluid->opening[1].model_pressure = tube->old->model;
    fluid->volume = volume(tube, area_of(tube, tube->old));
    return 0;
}

static int state(struct fsi_fluid *fluid, const void **bytes, uint64_t *length)
{
    struct tube *tube = fluid->own;
    *bytes = tube->old;
    *length = tube->size;
    return 0;
}

static int restore(struct fsi_fluid *fluid, const void *bytes, uint64_t length)
{
    struct tube *tube = fluid->own;
    if (length != tube->size) return sprintf(fluid->error, "the state is that of another tube"), -1;
    memcpy(tube->old, bytes, length);
    return 0;
}

/* Points and faces of the file FSI_WALL, all of four points. */
static void read_wall(struct fsi_fluid *fluid)
{
    FILE *file = fopen(fsi_told("FSI_WALL"), "r");
    char line[512];
    double *positions = NULL, *centres;
    uint32_t *vertices = NULL, *sizes, v[4];
    double x[3];
    if (!file) { perror("FSI_WALL"); exit(1); }
    while (fgets(line, sizeof line, file)) {
        if (sscanf(line, "v %lf %lf %lf", x, x + 1, x + 2) == 3) {
            positions = realloc(positions, 24ul * (fluid->points + 1));
            memcpy(positions + 3ul * fluid->points++, x, sizeof x);
        } else if (sscanf(line, "f %u %u %u %u", v, v + 1, v + 2, v + 3) == 4) {
            vertices = realloc(vertices, 16ul * (fluid->faces + 1));
            for (int k = 0; k < 4; ++k) vertices[4ul * fluid->faces + k] = v[k] - 1;
            ++fluid->faces;
        }
    }
    fclose(file);
    sizes = malloc(4ul * fluid->faces);
    centres = malloc(24ul * fluid->faces);
    fluid->positions = positions;
    fluid->vertices = vertices;
    for (uint32_t i = 0; i < fluid->faces; ++i) {
        double s[3];
        sizes[i] = 4;
        shape(fluid, NULL, i, s, centres + 3ul * i);
    }
    fluid->sizes = sizes;
    fluid->centres = centres;
}

/* Faces whose centres have the same x are a slice; slices in the order of x. */
static void slice(struct fsi_fluid *fluid, struct tube *tube)
{
    double *middles = malloc(8ul * fluid->faces);
    tube->slice_of = malloc(4ul * fluid->faces);
    tube->slices = 0;
    for (uint32_t i = 0; i < fluid->faces; ++i) {
        uint32_t k = 0;
        double x = fluid->centres[3 * i];
        while (k < tube->slices && middles[k] < x - 1e-9) ++k;
        if (k == tube->slices || middles[k] > x + 1e-9) {
            memmove(middles + k + 1, middles + k, 8ul * (tube->slices++ - k));
            middles[k] = x;
        }
    }
    tube->lengths = calloc(tube->slices, 8);
    for (uint32_t i = 0; i < fluid->faces; ++i) {
        uint32_t k = 0;
        while (fabs(middles[k] - fluid->centres[3 * i]) > 1e-9) ++k;
        tube->slice_of[i] = k;
        double least = INFINITY, most = -INFINITY;
        for (int j = 0; j < 4; ++j) {
            double x = fluid->positions[3 * fluid->vertices[4 * i + j]];
            least = fmin(least, x);
            most = fmax(most, x);
        }
        tube->lengths[k] = fmax(tube->lengths[k], most - least);
    }
    free(middles);
}

int main(int count, char **words)
{
    struct tube tube = {0};
    struct fsi_opening openings[] = {{.name = "inlet"}, {.name = "outlet", .has_model = 1}};
    struct fsi_fluid fluid = {.own = &tube, .openings = 2, .opening = openings, .solve = solve, .accept = accept_trial,
                              .state = state, .restore = restore};
    double *of[] = {&tube.rho, &tube.mu, &tube.inflow, &tube.ramp, &tube.resistance, &tube.compliance}, initial;
    if (count != 8) {
        fprintf(stderr, "usage: tube DENSITY VISCOSITY FLOW RAMP RESISTANCE COMPLIANCE INITIAL_PRESSURE\n");
        return 2;
    }
    for (int i = 0; i < 6; ++i) *of[i] = strtod(words[i + 1], NULL);
    initial = strtod(words[7], NULL);

    read_wall(&fluid);
    slice(&fluid, &tube);
    tube.size = sizeof(struct state) + (2ul * tube.slices + 1) * sizeof(double);
    tube.old = calloc(1, tube.size);
    tube.trial = calloc(1, tube.size);
    tube.shear = calloc(3ul * fluid.faces, 8);
    tube.pressure = calloc(tube.slices, 8);
    tube.old->model = initial;
    tube.old->time = strtod(fsi_told("FSI_START_TIME_S"), NULL);
    areas(&fluid, NULL, area_of(&tube, tube.old));
    fluid.volume = volume(&tube, area_of(&tube, tube.old));
    return fsi_serve(&fluid);
}
