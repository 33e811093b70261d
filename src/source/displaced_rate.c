// SPDX-License-Identifier: Apache-2.0
// Segments of edges and levels of maps of displaced meshes, by the formulas of shared/tessellation.h.
#include "source/displaced.h"

#include "base/thread.h"

// --------------------------------------------------------------------------------------------------------- vertices

vec3 clast_displaced_position(const displaced_unit *unit, const clast_pose *pose, const displaced_vertex *vertex)
{
    (void)unit;
    return load3(pose->positions != NULL ? pose->positions[vertex->mesh_vertex] : vertex->position);
}

static vec3 posed_triangle_normal(const clast_mesh *mesh, uint32_t triangle)
{
    const uint32_t *vertices = mesh->indices + 3 * (size_t)triangle;
    return displaced_triangle_normal(load3(clast_mesh_position(mesh, vertices[0])),
                                     load3(clast_mesh_position(mesh, vertices[1])),
                                     load3(clast_mesh_position(mesh, vertices[2])));
}

static vec3 posed_vertex_normal(const clast_mesh *mesh, uint32_t vertex)
{
    const float *normal = mesh->normals + 3 * (size_t)vertex;
    return stable_normalize3(vec3(normal[0], normal[1], normal[2]));
}

vec3 clast_displaced_normal(const displaced_unit *unit, const clast_pose *pose, const displaced_vertex *vertex)
{
    if (pose->positions == NULL && pose->normals == NULL) {
        return load3(vertex->normal);
    }
    const clast_mesh mesh = clast_mesh_posed(&unit->base.geometry->of.mesh, pose);
    bool by_vertex = unit->base.geometry->of.mesh.normals != NULL;
    uint32_t first = vertex[0].first_normal, end = vertex[1].first_normal;
    if (first == end) {
        return posed_vertex_normal(&mesh, vertex->mesh_vertex);
    }
    vec3 sum = splat3(0.0f);
    for (uint32_t i = first; i < end; i++) {
        displaced_normal part = unit->normals[i];
        vec3 normal = by_vertex ? posed_vertex_normal(&mesh, part.number) : posed_triangle_normal(&mesh, part.number);
        sum += normal * part.weight;
    }
    return stable_normalize3(sum);
}

// Boxes of chunks of vertices or triangles.
enum { BOX_CHUNKS = 64 };
typedef struct box_job {
    const displaced_unit *unit;
    const clast_pose *pose;
    size_t grain;
    clast_box boxes[BOX_CHUNKS];
} box_job;

static void widen(clast_box *box, vec3 point)
{
    box->lower = store3(min3(load3(box->lower), point));
    box->upper = store3(max3(load3(box->upper), point));
}

static void vertex_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    box_job *job = data;
    clast_box box = job->boxes[begin / job->grain];
    for (size_t i = begin; i < end; i++) {
        widen(&box, clast_displaced_position(job->unit, job->pose, &job->unit->vertices[i]));
    }
    job->boxes[begin / job->grain] = box;
}

// A curved triangle lies within the hull of the points that control it.
static void curved_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    box_job *job = data;
    const displaced_unit *unit = job->unit;
    const clast_mesh *mesh = &unit->base.geometry->of.mesh;
    clast_box box = job->boxes[begin / job->grain];
    for (size_t i = begin; i < end; i++) {
        vec3 p[3], n[3], sum = splat3(0.0f);
        for (uint32_t k = 0; k < 3; k++) {
            const displaced_vertex *vertex = &unit->vertices[unit->vertex_of[mesh->indices[3 * i + k]]];
            p[k] = clast_displaced_position(unit, job->pose, vertex);
            n[k] = clast_displaced_normal(unit, job->pose, vertex);
        }
        for (uint32_t k = 0; k < 6; k++) {
            vec3 control = curved_control(p, n, k);
            widen(&box, control);
            sum += control;
        }
        widen(&box, sum * 0.25f - (p[0] + p[1] + p[2]) * 0.166666667f);
    }
    job->boxes[begin / job->grain] = box;
}

static void add_boxes(box_job *job, size_t count, clast_range_function function)
{
    job->grain = (count + BOX_CHUNKS - 1) / BOX_CHUNKS;
    clast_parallel_for(job->unit->base.context, count, job->grain, function, job);
}

clast_box clast_displaced_rest_box(const displaced_unit *unit, const clast_pose *pose)
{
    clast_box box = {{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
    box_job job = {.unit = unit, .pose = pose};
    for (uint32_t i = 0; i < BOX_CHUNKS; i++) {
        job.boxes[i] = box;
    }
    add_boxes(&job, unit->vertex_count, vertex_range);
    if (unit->curved) {
        add_boxes(&job, unit->base.geometry->of.mesh.triangle_count, curved_range);
    }
    for (uint32_t i = 0; i < BOX_CHUNKS; i++) {
        box.lower = store3(min3(load3(box.lower), load3(job.boxes[i].lower))); // of some nothing
        box.upper = store3(max3(load3(box.upper), load3(job.boxes[i].upper)));
    }
    return box;
}

// ------------------------------------------------------------------------------------------------------------ faces

static vec2 own_coordinates(const displaced_unit *unit, const displaced_face *face, bool plain, uint32_t mesh_triangle,
                            uint32_t k)
{
    const clast_mesh *mesh = &unit->base.geometry->of.mesh;
    return plain ? load2(face->vertices[k]->coordinates)
                 : clast_displaced_coordinates(face->map, mesh, mesh->indices[3 * (size_t)mesh_triangle + k]);
}

displaced_face clast_displaced_face(const displaced_unit *unit, const clast_pose *pose,
                                    const displaced_cluster *cluster, uint32_t number)
{
    displaced_triangle triangle = unit->triangles[cluster->first_triangle + number];
    uint32_t mesh_triangle = unit->mesh_triangles[cluster->first_triangle + number];
    bool plain = displaced_is_plain(triangle);
    displaced_face face = {0};
    for (uint32_t k = 0; k < 3; k++) {
        face.vertices[k] = displaced_vertex_of(unit, cluster, displaced_corner(triangle, k));
        face.positions[k] = clast_displaced_position(unit, pose, face.vertices[k]);
        face.normals[k] = clast_displaced_normal(unit, pose, face.vertices[k]);
    }
    for (uint32_t k = 0; unit->curved && k < 6; k++) {
        face.controls[k] = curved_control(face.positions, face.normals, k);
    }
    face.map = &unit->maps[plain ? face.vertices[0]->map : displaced_map_of(unit, mesh_triangle)];
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t seam = displaced_seam_of(unit->edges[cluster->first_edge + displaced_edge_of(triangle, k)]);
        face.coordinates[k] = own_coordinates(unit, &face, plain, mesh_triangle, k);
        face.seams[k] = !plain && seam != DISPLACED_NO_SEAM ? &unit->seams[cluster->first_seam + seam] : NULL;
        face.along[k] = displaced_goes_along(triangle, k);
    }
    return face;
}

displaced_site clast_displaced_site_within(const displaced_unit *unit, const displaced_face *face, clast_weights at,
                                           uint32_t place)
{
    uint32_t edge = place - WEIGHTS_EDGE;
    if (place >= WEIGHTS_INSIDE || face->seams[edge] == NULL) {
        return (displaced_site){
            face->map,
            blend2(face->coordinates[0], face->coordinates[1], face->coordinates[2], at),
        };
    }
    const displaced_seam *seam = face->seams[edge];
    vec2 first = load2(seam->coordinates[face->along[edge] ? 0 : 1]);
    vec2 second = load2(seam->coordinates[face->along[edge] ? 1 : 0]);
    return (displaced_site){&unit->maps[seam->map],
                            displaced_seam_blend(first, second, at.of[edge], at.of[(edge + 1) % 3])};
}

displaced_site clast_displaced_site(const displaced_unit *unit, const displaced_face *face, clast_weights at)
{
    uint32_t place = weights_place(at);
    if (place < WEIGHTS_EDGE) {
        const displaced_vertex *vertex = face->vertices[place];
        return (displaced_site){&unit->maps[vertex->map], load2(vertex->coordinates)};
    }
    return clast_displaced_site_within(unit, face, at, place);
}

vec3 clast_displaced_base(const displaced_unit *unit, const displaced_face *face, clast_weights at)
{
    return unit->curved ? curved_blend(face->positions, face->controls, curved_weights(at))
                        : blend3(face->positions[0], face->positions[1], face->positions[2], at);
}

// ------------------------------------------------------------------------------------------------------------ rates

clast_rate_view clast_displaced_rate_view(const displaced_unit *unit, const clast_pose *pose,
                                          const clast_source_view *view)
{
    bool still = pose->positions == NULL && pose->normals == NULL;
    return rate_view(*view, displaced_faces(unit->header, pose->displacement_scale, load3(view->eye), still));
}

// The last vertex again up to a whole number of lanes.
static void gather_points(const displaced_unit *unit, const clast_pose *pose, const displaced_cluster *cluster,
                          clast_rate_points *points)
{
    uint32_t end = (cluster->vertex_count + RATE_LANES_MOST - 1) / RATE_LANES_MOST * RATE_LANES_MOST;
    for (uint32_t i = 0; i < end; i++) {
        const displaced_vertex *vertex = displaced_vertex_of(unit, cluster, min_uint(i, cluster->vertex_count - 1));
        vec3 position = clast_displaced_position(unit, pose, vertex),
             normal = clast_displaced_normal(unit, pose, vertex);
        for (uint32_t k = 0; k < 3; k++) {
            points->positions[k][i] = position[k];
            points->normals[k][i] = normal[k];
        }
        points->heights[i] = vertex->height * pose->displacement_scale;
        points->density_squares[i] = vertex->density_square;
        points->shortest_squares[i] = vertex->shortest_square;
    }
}

void clast_displaced_rates(const displaced_unit *unit, const clast_pose *pose, const clast_rate_view *view,
                           const displaced_cluster *cluster, displaced_rates *rates)
{
    const clast_rate_kernels *kernels = clast_rate_kernels_of(clast_context_isa(unit->base.context));
    clast_rate_points points;
    clast_rate_site sites[RATE_POINTS];
    gather_points(unit, pose, cluster, &points);
    kernels->points(view, &points, cluster->vertex_count, sites, rates->levels);
    clast_rate_edges edges = {
        .sites = sites,
        .edges = unit->edges + cluster->first_edge,
        .count = cluster->edge_count,
        .scale = pose->displacement_scale,
        .curved = unit->curved,
    };
    kernels->edges(view, &edges, rates->factors);
}

float clast_displaced_wanted(const displaced_unit *unit, const clast_pose *pose, const clast_rate_view *view,
                             const displaced_cluster *cluster, uint32_t edge)
{
    displaced_edge of = unit->edges[cluster->first_edge + edge];
    vec3 p[2], n[2];
    clast_rate_point ends[2];
    for (uint32_t k = 0; k < 2; k++) {
        const displaced_vertex *vertex = displaced_vertex_of(unit, cluster, of.ends >> 8 * k & 255);
        p[k] = clast_displaced_position(unit, pose, vertex);
        n[k] = clast_displaced_normal(unit, pose, vertex);
        ends[k] = rate_point(*view, displaced_point(p[k], n[k], vertex->height * pose->displacement_scale), n[k]);
    }
    vec3 normal = (n[0] + n[1]) * 0.5f;
    vec3 moved = displaced_point(displaced_middle(p[0], p[1], n[0], n[1], unit->curved), normal,
                                 of.height * pose->displacement_scale);
    clast_rate_point middle = rate_point(*view, moved, normal);
    return edge_wanted(*view, ends[0], middle, ends[1], clast_rate_open(view, ends[0], middle, ends[1]));
}
