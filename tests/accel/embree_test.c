// SPDX-License-Identifier: Apache-2.0
// The hits of Embree (robust) on the same rays; they may differ only where a ray passes an edge, or two triangles are at the
// same distance.
#include "test.h"

#include "accel/meshes.h"
#include "embree.h"
#include "embree_agreement.h"

enum { RAYS = 100000 };

static void compare(clast_context *context, mesh m, float extent)
{
    clustered c;
    clast_tlas *tlas;
    RTCDevice device = rtcNewDevice("threads=1");
    assert_ok(context, clustered_make(context, &m, 128, &c));
    assert_ok(context, clast_tlas_create(context, &tlas));
    clast_tlas_instance instance = instance_of(c.blas, 0);
    assert_ok(context, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
    embree_mesh theirs = embree_mesh_make(device, m.positions, m.vertex_count, m.indices, m.triangle_count,
                                          RTC_BUILD_QUALITY_MEDIUM, RTC_SCENE_FLAG_ROBUST);
    agreement a = {.scale = extent};
    randoms r = {21};
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_ray ray = {.t_max = i % 3 == 0 ? extent : INFINITY};
        for (uint32_t axis = 0; axis < 3; axis++) {
            ray.origin[axis] = random_between(&r, -extent, extent);
            ray.direction[axis] = random_between(&r, -1, 1);
        }
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        struct RTCRayHit expected = embree_closest(theirs.scene, &ray, false);
        uint32_t triangle = hit.instance == 0 ? c.first_triangles[hit.cluster] + hit.triangle : CLAST_NONE;
        agreement_count(&a, &ray, agreement_corners(&m, triangle), hit.t, agreement_corners(&m, expected.hit.primID),
                        expected.ray.tfar);
    }
    assert_true(a.hits > RAYS / 100);
    assert_int_equal(a.wrong, 0);
    assert_true(a.ties < RAYS / 1000);
    rtcReleaseScene(theirs.scene);
    rtcReleaseDevice(device);
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    mesh_free(&m);
}

static void a_soup_is_hit_as_embree_hits_it(void **state)
{
    compare(*state, mesh_soup(20000, 0.1f, 1), 1.5f);
}

static void a_terrain_is_hit_as_embree_hits_it(void **state)
{
    compare(*state, mesh_terrain(150, 0.1f, 1), 1.0f);
}

static void a_ball_is_hit_as_embree_hits_it(void **state)
{
    mesh m = mesh_octasphere(5);
    mesh_displace(&m, 0.2f, 5);
    compare(*state, m, 1.5f);
}

static void large_triangles_are_hit_as_embree_hits_them(void **state)
{
    compare(*state, mesh_soup(200, 1.0f, 3), 2.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_soup_is_hit_as_embree_hits_it),
        CONTEXT_TEST(a_terrain_is_hit_as_embree_hits_it),
        CONTEXT_TEST(a_ball_is_hit_as_embree_hits_it),
        CONTEXT_TEST(large_triangles_are_hit_as_embree_hits_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
