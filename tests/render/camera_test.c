// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>

#include "scene/scene.h"
#include "shared/camera.h"
#include "shared/sampling.h"

#define assert_near(value, expected, tolerance) \
    assert_true(fabs((double)(value) - (double)(expected)) <= (double)(tolerance))

static clast_camera looking_down_z(clast_projection projection)
{
    return (clast_camera){
        .projection = projection,
        .position = {{1.0f, 2.0f, 3.0f}},
        .right = {{1.0f, 0.0f, 0.0f}},
        .up = {{0.0f, 1.0f, 0.0f}},
        .forward = {{0.0f, 0.0f, -1.0f}},
        .vertical_extent = 0.5f,
        .aspect = 2.0f,
    };
}

static void the_middle_of_the_picture_looks_forward(void **state)
{
    (void)state;
    clast_camera_ray ray = camera_ray(looking_down_z(CLAST_PROJECTION_PERSPECTIVE), 0.5f, 0.5f);
    assert_near(ray.direction.v[0], 0.0, 0.0);
    assert_near(ray.direction.v[1], 0.0, 0.0);
    assert_near(ray.direction.v[2], -1.0, 0.0);
    assert_near(ray.origin.v[0], 1.0, 0.0);
    assert_true(ray.t_min == 0.0f && isinf(ray.t_max));
}

static void the_upper_left_corner_is_up_and_left_by_the_angles(void **state)
{
    (void)state;
    clast_camera_ray ray = camera_ray(looking_down_z(CLAST_PROJECTION_PERSPECTIVE), 0.0f, 0.0f);
    assert_near(ray.direction.v[0] / -ray.direction.v[2], -1.0, 1e-6);
    assert_near(ray.direction.v[1] / -ray.direction.v[2], 0.5, 1e-6);
    assert_near(length3(load3(ray.direction)), 1.0, 1e-6);
}

static void orthographic_rays_are_parallel(void **state)
{
    (void)state;
    clast_camera_ray ray = camera_ray(looking_down_z(CLAST_PROJECTION_ORTHOGRAPHIC), 1.0f, 1.0f);
    assert_near(ray.origin.v[0], 2.0, 1e-6);
    assert_near(ray.origin.v[1], 1.5, 1e-6);
    assert_near(ray.direction.v[2], -1.0, 0.0);
}

static void planes_bound_the_depth_not_the_distance(void **state)
{
    (void)state;
    clast_camera camera = looking_down_z(CLAST_PROJECTION_PERSPECTIVE);
    camera.near_plane = 2.0f;
    camera.far_plane = 10.0f;
    clast_camera_ray ray = camera_ray(camera, 0.0f, 0.0f);
    assert_near(camera_depth(camera, ray, ray.t_min), 2.0, 1e-5);
    assert_near(camera_depth(camera, ray, ray.t_max), 10.0, 1e-5);
    assert_true(ray.t_min > 2.0f);
}

static void the_pixel_filter_is_a_tent_around_the_centre(void **state)
{
    (void)state;
    double mean = 0.0, square = 0.0;
    for (uint32_t i = 0; i < 65536; i++) {
        float offset = camera_offset(unit_float(i << 16));
        assert_true(offset >= -0.5f && offset <= 1.5f);
        mean += (double)offset;
        square += ((double)offset - 0.5) * ((double)offset - 0.5);
    }
    assert_near(mean / 65536.0, 0.5, 1e-4);
    assert_near(square / 65536.0, 1.0 / 6.0, 1e-4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_middle_of_the_picture_looks_forward),
        cmocka_unit_test(the_upper_left_corner_is_up_and_left_by_the_angles),
        cmocka_unit_test(orthographic_rays_are_parallel),
        cmocka_unit_test(planes_bound_the_depth_not_the_distance),
        cmocka_unit_test(the_pixel_filter_is_a_tent_around_the_centre),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
