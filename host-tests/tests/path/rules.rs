//! The rules of SPEC 5 "Coordinate systems" and of SPEC 6 about light on a path, each as a small
//! job with its outcome worked out by hand. Times are ms from the tick at which the coordinate
//! system starts.
use host_tests::laser_model::Family;

/// A rule. The channel is in analog mode with a direct power of 5 V, unless the body says something
/// else.
pub struct Rule {
    pub name: &'static str,
    pub family: Family,
    /// Calls; `GO` starts coordinate system 1 at 0 ms.
    pub body: &'static str,
    /// When channel 0's switch is on; to the end where it is not switched off.
    pub light: &'static [(f64, f64)],
    /// Where axes are: ms, axis from 1, pulses.
    pub places: &'static [(f64, usize, f64)],
    /// Power of channel 0: ms, V.
    pub power: &'static [(f64, f64)],
    /// When general output 1 is on.
    pub output: &'static [(f64, f64)],
}

/// To the end.
pub const END: f64 = f64::MAX;

const NONE: Rule = Rule { name: "", family: Family::Gus, body: "", light: &[], places: &[], power: &[], output: &[] };

/// Everything about motion. 500 pulses at 10 with 2: 5 ms over 25, 45 ms, 5 ms.
pub const MOTION: &[Rule] = &[
    Rule {
        name: "the_speed_along_a_line_is_a_trapezoid",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 55.0)],
        places: &[(5.0, 1, 25.0), (50.0, 1, 475.0), (55.0, 1, 500.0), (55.0, 2, 0.0)],
        ..NONE
    },
    Rule {
        name: "the_speed_is_that_along_the_path",
        // 3, 4, 5; 12 from them makes 13; 84 makes 85.
        body: "crd.dimension=4;crd.profile[2]=3;crd.profile[3]=4;GT_SetCrdPrm(1,&crd);GT_BufLaserOn(1);GT_LnXYZA(1,30,40,120,840,10,2);GT_BufLaserOff(1);GO",
        // 850 pulses.
        light: &[(0.0, 90.0)],
        places: &[(45.0, 1, 15.0), (45.0, 2, 20.0), (45.0, 3, 60.0), (45.0, 4, 420.0), (90.0, 4, 840.0)],
        ..NONE
    },
    Rule {
        name: "the_end_velocity_is_held_to_the_velocity",
        body: "GT_BufLaserOn(1);GT_LnXY(1,100,0,10,1,99);GT_BufLaserOff(1);GT_LnXY(1,200,0,10,1);GO",
        light: &[(0.0, 15.0)],
        places: &[(10.0, 1, 50.0), (15.0, 1, 100.0), (20.0, 1, 150.0), (30.0, 1, 200.0)],
        ..NONE
    },
    Rule {
        name: "an_end_velocity_out_of_reach_is_neared_and_the_next_begins_with_it",
        // √(2·2·4) = 4, from which the next 4 pulses just suffice.
        body: "GT_BufLaserOn(1);GT_LnXY(1,4,0,10,2,9);GT_BufLaserOff(1);GT_LnXY(1,8,0,10,2);GO",
        light: &[(0.0, 2.0)],
        places: &[(1.0, 1, 1.0), (2.0, 1, 4.0), (3.0, 1, 7.0), (4.0, 1, 8.0)],
        ..NONE
    },
    Rule {
        name: "a_motion_entered_above_its_velocity_brakes_to_it",
        // 15 ms; 10 to 6 over 16 in 2 ms, 84 in 14 ms, 6 to 2 over 8 in 2 ms; 1 pulse from 2 to 0
        // in 1 ms.
        body: "GT_BufLaserOn(1);GT_LnXY(1,100,0,10,1,10);GT_LnXY(1,208,0,6,2,2);GT_BufLaserOff(1);GT_LnXY(1,209,0,2,2);GO",
        light: &[(0.0, 33.0)],
        places: &[(15.0, 1, 100.0), (17.0, 1, 116.0), (31.0, 1, 200.0), (33.0, 1, 208.0), (34.0, 1, 209.0)],
        ..NONE
    },
    Rule {
        name: "where_nothing_follows_the_speed_goes_to_0",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2,10);GT_BufLaserOff(1);GO",
        light: &[(0.0, 55.0)],
        places: &[(50.0, 1, 475.0), (55.0, 1, 500.0)],
        ..NONE
    },
    Rule {
        name: "a_delay_is_waited_for_at_rest",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2,10);GT_BufLaserOff(1);GT_BufDelay(1,7);GT_BufLaserOn(1);GT_LnXY(1,1000,0,10,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 55.0), (62.0, 117.0)],
        places: &[(50.0, 1, 475.0), (61.0, 1, 500.0), (67.0, 1, 525.0)],
        ..NONE
    },
    Rule {
        name: "the_even_time_lowers_the_peak",
        // 8·8/2 + 10·8 = 112.
        body: "crd.evenTime=10;GT_SetCrdPrm(1,&crd);GT_BufLaserOn(1);GT_LnXY(1,112,0,20,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 18.0)],
        places: &[(4.0, 1, 16.0), (14.0, 1, 96.0)],
        ..NONE
    },
    Rule {
        name: "velocity_and_acceleration_are_held_to_those_of_the_coordinate_system",
        body: "crd.synVelMax=10;crd.synAccMax=2;GT_SetCrdPrm(1,&crd);GT_BufLaserOn(1);GT_LnXY(1,500,0,50,9);GT_BufLaserOff(1);GO",
        light: &[(0.0, 55.0)],
        places: &[(5.0, 1, 25.0), (50.0, 1, 475.0)],
        ..NONE
    },
    Rule {
        name: "an_end_equal_to_the_start_is_a_full_circle",
        // 200π: 10 ms and (200π − 50)/10; after 25 pulses 0.25 rad, clockwise about (100, 0).
        body: "GT_BufLaserOn(1);GT_ArcXYC(1,0,0,100,0,0,10,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 67.831_853_071_8)],
        places: &[(5.0, 1, 3.108_757_829), (5.0, 2, 24.740_395_925), (68.0, 1, 0.0), (68.0, 2, 0.0)],
        ..NONE
    },
    Rule {
        name: "direction_1_is_counterclockwise",
        body: "GT_ArcXYC(1,0,0,100,0,1,10,2);GO",
        places: &[(5.0, 1, 3.108_757_829), (5.0, 2, -24.740_395_925)],
        ..NONE
    },
    Rule {
        name: "a_radius_above_0_means_the_arc_up_to_180_degrees",
        // 50π, about (0, 100).
        body: "GT_BufLaserOn(1);GT_ArcXYR(1,100,100,100,1,10,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 20.707_963_267_9)],
        places: &[(5.0, 1, 24.740_395_925), (5.0, 2, 3.108_757_829), (21.0, 1, 100.0), (21.0, 2, 100.0)],
        ..NONE
    },
    Rule {
        name: "a_radius_below_0_means_the_longer_arc",
        // 150π, about (100, 0).
        body: "GT_BufLaserOn(1);GT_ArcXYR(1,100,100,-100,1,10,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 52.123_889_803_8)],
        places: &[(5.0, 1, 3.108_757_829), (5.0, 2, -24.740_395_925), (53.0, 1, 100.0), (53.0, 2, 100.0)],
        ..NONE
    },
    Rule {
        name: "arcs_lie_in_three_planes",
        body: "crd.dimension=3;crd.profile[2]=3;GT_SetCrdPrm(1,&crd);GT_ArcYZR(1,100,100,100,1,10,2);GT_BufDelay(1,9);GT_ArcZXC(1,100,0,-100,0,1,10,2);GO",
        // The first as above; from 29.707… on a full circle about Z 0, X 0 from Z 100: Z turns to
        // X.
        places: &[
            (5.0, 1, 0.0),
            (5.0, 2, 24.740_395_925),
            (5.0, 3, 3.108_757_829),
            (25.0, 1, 0.0),
            (25.0, 2, 100.0),
            (25.0, 3, 100.0),
            // 5 ms and 5.292… ms at 10 pulse/ms later: 25 + 52.92… = 77.92036… pulses, by 100.
            (40.0, 1, 70.271_307_7),
            (40.0, 3, 71.147_335_3),
            (40.0, 2, 100.0),
        ],
        ..NONE
    },
    Rule {
        name: "an_axis_drives_the_coordinate_that_it_is_mapped_to",
        body: "crd.profile[0]=2;crd.profile[1]=1;GT_SetCrdPrm(1,&crd);GT_LnXY(1,300,400,10,2);GO",
        places: &[(55.0, 1, 400.0), (55.0, 2, 300.0), (30.0, 2, 165.0)],
        ..NONE
    },
    Rule {
        name: "targets_count_from_the_origin",
        // The origin lies at (1000, −200): from −1000 to −500 along X.
        body: "crd.originPos[0]=1000;crd.originPos[1]=-200;GT_SetCrdPrm(1,&crd);GT_BufLaserOn(1);GT_LnXY(1,-500,200,10,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 55.0)],
        places: &[(5.0, 1, 25.0), (55.0, 1, 500.0), (55.0, 2, 0.0)],
        ..NONE
    },
    Rule {
        name: "without_an_origin_it_is_where_the_axes_are",
        body: "GT_LnXY(1,100,0,10,1);Sleep(1);GT_CrdStart(1);Sleep(60);crd.setOriginFlag=0;GT_SetCrdPrm(1,&crd);GT_CrdClear(1,0);GT_LnXY(1,500,0,10,2);Sleep(1);GT_CrdStart(1);Sleep(38);GO2",
        // The second start was 38 ms ago, from 100.
        places: &[(12.0, 1, 575.0), (20.0, 1, 600.0)],
        ..NONE
    },
    Rule {
        name: "buffered_outputs_come_at_the_boundary",
        body: "GT_LnXY(1,4,0,10,2,9);GT_BufIO(1,12,1,1);GT_LnXY(1,8,0,10,2);GT_BufIO(1,12,1,0);GO",
        output: &[(2.0, 4.0)],
        ..NONE
    },
    Rule {
        name: "a_smooth_stop_brakes_through_what_follows_and_a_start_goes_on",
        // 20 pulses to the corner with 2: (10 − √20)/2 ms, rest 5 ms after the Stop; 95 are left:
        // 2·√95.
        body: "GT_SetCrdStopDec(1,2,100);GT_BufLaserOn(1);GT_LnXY(1,100,0,10,1,10);GT_BufLaserOff(1);GT_LnXY(1,200,0,10,1);GT_BufIO(1,12,1,1);GO Sleep(13);GT_Stop(256,0);Sleep(16);GT_CrdStart(1);",
        light: &[(0.0, 15.763_932_022_5)],
        places: &[
            (13.0, 1, 80.0),
            (15.0, 1, 96.0),
            (18.0, 1, 105.0),
            (29.0, 1, 105.0),
            (31.0, 1, 107.0),
            (49.0, 1, 200.0),
        ],
        output: &[(48.493_588_689_6, END)],
        ..NONE
    },
    Rule {
        name: "a_smooth_stop_brakes_with_the_greatest_acceleration_by_itself",
        // 100: from 10 to 0 in 0.1 ms over 0.5.
        body: "GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,0);",
        places: &[(30.0, 1, 275.0), (31.0, 1, 275.5), (60.0, 1, 275.5)],
        ..NONE
    },
    Rule {
        name: "an_abrupt_stop_rests_on_its_tick",
        body: "GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(20);GT_CrdStart(1);",
        // 275 at 30 ms: its tick shows the set-point of the tick before. The rest is 227.5: 27.75
        // ms.
        places: &[(29.75, 1, 272.5), (30.0, 1, 272.5), (49.0, 1, 272.5), (55.0, 1, 297.5), (77.75, 1, 500.0)],
        ..NONE
    },
    Rule {
        name: "a_stop_of_a_mapped_axis_stops_its_coordinate_system",
        body: "GT_LnXY(1,300,400,10,2);GO Sleep(30);GT_Stop(2,2);Sleep(20);GT_CrdStart(1);",
        places: &[(30.0, 1, 163.5), (49.0, 1, 163.5), (49.0, 2, 218.0), (55.0, 2, 238.0), (77.75, 1, 300.0)],
        ..NONE
    },
    Rule {
        name: "crd_stop_is_the_gtn_form",
        body: "GT_LnXY(1,500,0,10,2);GO Sleep(30);GTN_CrdStop(1,1,1);Sleep(20);GT_CrdStart(1);",
        places: &[(49.0, 1, 272.5), (55.0, 1, 297.5)],
        ..NONE
    },
    Rule {
        name: "fifo_1_interrupts_fifo_0_and_returns",
        // 12.5 in 2.5 ms, 285 at the tick before the Stop. There and back by 100 along Y: 15 ms
        // each. The rest is 215: 24 ms.
        body: "GT_LnXY(1,500,0,10,4);GO Sleep(30);GT_Stop(256,256);Sleep(1);GT_LnXY(1,285,100,10,2,0,1);GT_LnXY(1,285,0,10,2,0,1);GT_CrdStart(1,1);Sleep(40);GT_CrdStart(1,0);",
        places: &[
            (46.0, 2, 100.0),
            (46.0, 1, 285.0),
            (61.0, 2, 0.0),
            (70.0, 1, 285.0),
            (76.0, 1, 322.5),
            (95.0, 1, 500.0),
        ],
        ..NONE
    },
    Rule {
        name: "an_override_scales_the_velocity",
        // 5: 2.5 ms, 97.5 ms, 2.5 ms.
        body: "GT_SetOverride(1,0.5);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_BufLaserOff(1);GO",
        light: &[(0.0, 102.5)],
        places: &[(52.5, 1, 256.25)],
        ..NONE
    },
    Rule {
        name: "an_override_acts_while_it_runs",
        // At 175; down to 5 over 18.75 in 2.5 ms; 300 in 60 ms; 2.5 ms.
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_BufLaserOff(1);GO Sleep(20);GT_SetOverride(1,0.5);",
        light: &[(0.0, 85.0)],
        places: &[(20.0, 1, 175.0), (22.5, 1, 193.75), (82.5, 1, 493.75)],
        ..NONE
    },
    Rule {
        name: "two_coordinate_systems_start_on_one_tick",
        body: "GT_LnXY(1,500,0,10,2);crd.profile[0]=0;crd.profile[1]=0;crd.profile[2]=1;crd.profile[3]=2;GT_SetCrdPrm(2,&crd);GT_LnXY(2,0,100,10,1);Sleep(90);GT_CrdStart(3,0);Sleep(10);GO2",
        // Both began 10 ms ago.
        places: &[(1.0, 1, 85.0), (1.0, 4, 59.5), (45.0, 1, 500.0), (10.0, 4, 100.0)],
        ..NONE
    },
];

/// Light on a path.
pub const LIGHT: &[Rule] = &[
    Rule {
        name: "what_entries_lit_goes_off_when_they_have_run_out",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        light: &[(0.0, 55.0)],
        power: &[(20.0, 5.0), (56.0, 0.0)],
        ..NONE
    },
    Rule {
        name: "a_power_changes_at_the_corner",
        // 2 ms into the path, between two ticks of the trace none: a row at 2 ms has the second.
        body: "GT_BufLaserOn(1);GT_BufLaserPrfCmd(1,4);GT_LnXY(1,4,0,10,2,9);GT_BufLaserPrfCmd(1,3);GT_LnXY(1,8,0,10,2);GO",
        light: &[(0.0, 4.0)],
        power: &[(1.75, 4.0), (2.0, 3.0), (3.75, 3.0), (4.0, 0.0)],
        ..NONE
    },
    Rule {
        name: "a_stop_takes_what_entries_lit_and_the_start_brings_it_back_with_their_delays",
        body: "GT_SetLevelDelay(130,77);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(20);GT_CrdStart(1);",
        light: &[(0.077, 30.13), (50.077, 77.88)],
        ..NONE
    },
    Rule {
        name: "a_smooth_stop_takes_it_where_it_rests",
        // 10 to 0 with 4: 2.5 ms.
        body: "GT_SetCrdStopDec(1,4,100);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,0);",
        light: &[(0.0, 32.5)],
        ..NONE
    },
    Rule {
        name: "a_start_after_a_clear_does_not_resume_light",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(5);GT_CrdClear(1,0);GT_LnXY(1,500,0,10,2);Sleep(5);GT_CrdStart(1);",
        light: &[(0.0, 30.0)],
        places: &[(40.0, 1, 272.5), (45.0, 1, 297.5)],
        ..NONE
    },
    Rule {
        name: "light_that_fifo_1_interrupts_comes_back_with_fifo_0",
        // FIFO 1 goes 15 ms there and 15 back; 215 pulses are left for 24 ms.
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,4);GO Sleep(30);GT_Stop(256,256);Sleep(1);GT_LnXY(1,285,100,10,2,0,1);GT_LnXY(1,285,0,10,2,0,1);GT_CrdStart(1,1);Sleep(40);GT_CrdStart(1,0);",
        light: &[(0.0, 30.0), (71.0, 95.0)],
        places: &[(46.0, 2, 100.0), (61.0, 2, 0.0), (76.0, 1, 322.5)],
        ..NONE
    },
    Rule {
        name: "fifo_1_does_not_go_on_with_the_light_of_fifo_0",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,4);GO Sleep(30);GT_Stop(256,256);Sleep(1);GT_LnXY(1,285,100,10,2,0,1);GT_LnXY(1,285,0,10,2,0,1);GT_CrdStart(1,1);Sleep(5);GT_Stop(256,256);Sleep(5);GT_CrdStart(1,1);Sleep(40);GT_CrdStart(1,0);",
        light: &[(0.0, 30.0), (81.0, 105.0)],
        ..NONE
    },
    Rule {
        name: "an_off_command_of_fifo_1_stays",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,4);GO Sleep(30);GT_Stop(256,256);Sleep(1);GT_BufLaserOff(1,1);GT_LnXY(1,285,100,10,2,0,1);GT_LnXY(1,285,0,10,2,0,1);GT_CrdStart(1,1);Sleep(40);GT_CrdStart(1,0);",
        light: &[(0.0, 30.0)],
        places: &[(76.0, 1, 322.5)],
        ..NONE
    },
    Rule {
        // "When the entries of crd k have run out, what its entries lit and every light under its
        // velocity follow is shut off".
        name: "light_of_a_command_under_a_follow_goes_off_when_the_entries_have_run_out",
        body: "GT_SetHSIOOpt(1);GT_BufLaserPrfFollow(1,0.5,1,9);GT_LnXY(1,500,0,10,2);GO Sleep(70);",
        light: &[(-10.0, 55.0)],
        power: &[(20.0, 6.0), (60.0, 0.0)],
        ..NONE
    },
    Rule {
        // Only these: its own light, and that under its follow.
        name: "light_of_a_command_outlives_the_end_of_the_entries",
        body: "GT_SetHSIOOpt(1);GT_LnXY(1,500,0,10,2);GO Sleep(70);",
        light: &[(-10.0, END)],
        power: &[(20.0, 5.0), (60.0, 5.0)],
        ..NONE
    },
    Rule {
        // "A buffered on takes over light of a call".
        name: "an_on_entry_takes_over_light_of_a_command",
        body: "GT_SetHSIOOpt(1);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(70);",
        light: &[(-10.0, 55.0)],
        ..NONE
    },
    Rule {
        // "An immediate on while a crd's light is on changes nothing": it stays the path's, and
        // ends with it.
        name: "an_immediate_on_changes_nothing_while_a_path_has_light",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(5);GT_SetHSIOOpt(1);Sleep(60);",
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        // "A Stop of crd k shuts off every channel whose map holds k, whoever lit it"; "The
        // CrdStart that goes on after a Stop … brings back what that Stop shut off". 227.5 pulses
        // are left for 27.75 ms, and no entry ends the light.
        name: "a_stop_takes_light_of_a_command_and_the_start_brings_it_back",
        body: "GT_SetHSIOOpt(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(20);GT_CrdStart(1);Sleep(40);",
        light: &[(-10.0, 30.0), (50.0, END)],
        ..NONE
    },
    Rule {
        // "an on or off command in between replaces it".
        name: "an_on_command_at_rest_lights",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(5);GT_SetHSIOOpt(1);Sleep(5);GT_CrdStart(1);",
        light: &[(0.0, 30.0), (35.0, END)],
        ..NONE
    },
    Rule {
        // "nothing else brings light back: … not one after a Stop that found the crd at rest".
        name: "a_second_stop_finds_it_at_rest_and_nothing_comes_back",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(5);GT_Stop(256,0);Sleep(5);GT_CrdStart(1);",
        light: &[(0.0, 30.0)],
        places: &[(45.0, 1, 297.5)],
        ..NONE
    },
    Rule {
        name: "a_stop_at_rest_takes_light_of_a_command",
        body: "GT_SetHSIOOpt(1);GT_LnXY(1,500,0,10,2);GO Sleep(70);GT_Stop(256,0);",
        light: &[(-10.0, 70.0)],
        ..NONE
    },
    Rule {
        // "While a crd brakes for a Stop its entries act as on the way, so that a mark has no gap".
        // The corner after (10 − √20)/2 ms, rest 5 ms after the Stop; 95 pulses are left for 2·√95
        // ms.
        name: "what_is_passed_in_braking_acts",
        body: "GT_SetCrdStopDec(1,2,100);GT_LnXY(1,100,0,10,1,10);GT_BufLaserOn(1);GT_LnXY(1,200,0,10,1);GO Sleep(13);GT_Stop(256,0);Sleep(16);GT_CrdStart(1);",
        light: &[(15.763_932_022_5, 18.0), (29.0, 48.493_588_689_6)],
        ..NONE
    },
    Rule {
        // "but after an immediate off before or during the braking, with no on command since,
        // nothing that it passes lights".
        name: "after_an_off_command_nothing_that_is_passed_in_braking_lights",
        body: "GT_SetCrdStopDec(1,2,100);GT_BufLaserOn(1);GT_LnXY(1,100,0,10,1,10);GT_BufLaserOff(1);GT_BufLaserOn(1);GT_LnXY(1,200,0,10,1);GO Sleep(13);GT_Stop(256,0);Sleep(1);GT_SetHSIOOpt(0);Sleep(15);GT_CrdStart(1);",
        light: &[(0.0, 14.0)],
        ..NONE
    },
    Rule {
        name: "nor_after_an_off_command_before_the_braking",
        body: "GT_SetCrdStopDec(1,2,100);GT_BufLaserOn(1);GT_LnXY(1,100,0,10,1,10);GT_BufLaserOn(1);GT_LnXY(1,200,0,10,1);GO Sleep(10);GT_SetHSIOOpt(0);Sleep(3);GT_Stop(256,0);Sleep(16);GT_CrdStart(1);",
        light: &[(0.0, 10.0)],
        ..NONE
    },
    Rule {
        name: "an_off_command_at_rest_stays",
        body: "GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(5);GT_SetHSIOOpt(0);Sleep(5);GT_CrdStart(1);",
        light: &[(0.0, 30.0)],
        ..NONE
    },
    Rule {
        name: "a_delay_is_no_rest_but_has_the_minimum_power",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_BufDelay(1,10);GT_LnXY(1,1000,0,10,2);GO",
        light: &[(0.0, 120.0)],
        power: &[(20.0, 6.0), (60.0, 1.0), (90.0, 6.0)],
        ..NONE
    },
    Rule {
        // "Ending or replacing a follow never lights"; the CrdStart that goes on "brings back what
        // that Stop shut off", with the direct power. 227.5 pulses are left for 27.75 ms.
        name: "ending_a_follow_at_rest_does_not_light_and_the_start_does",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(5);GT_Stop(1024,0);Sleep(5);GT_CrdStart(1);",
        light: &[(0.0, 30.0), (40.0, 67.75)],
        power: &[(20.0, 6.0), (36.0, 0.0), (50.0, 5.0)],
        ..NONE
    },
    Rule {
        // "an on command given then lights with the next CrdStart of that crd".
        name: "an_on_command_under_a_follow_at_rest_waits_for_the_start",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(5);GT_SetHSIOOpt(1);Sleep(5);GT_CrdStart(1);",
        light: &[(40.0, 67.75)],
        power: &[(36.0, 0.0), (50.0, 6.0)],
        ..NONE
    },
    Rule {
        // What waits for the follow's path is withdrawn with the follow.
        name: "what_waits_does_not_outlive_its_follow",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);Sleep(5);GT_SetHSIOOpt(1);Sleep(5);GT_Stop(1024,0);Sleep(5);GT_CrdStart(1);",
        light: &[],
        places: &[(50.0, 1, 297.5)],
        ..NONE
    },
    Rule {
        // "A crd lights only channels whose map holds it"; a Stop shuts off those "whose map holds
        // k", no other.
        name: "a_map_without_the_coordinate_system_keeps_light_of_a_command",
        body: "GT_SetLaserCrdMap(0,2);GT_SetHSIOOpt(1);GT_LnXY(1,500,0,10,2);GO Sleep(30);GT_Stop(256,256);",
        light: &[(-10.0, END)],
        ..NONE
    },
    Rule {
        // "one that is reached when the map no longer holds its crd does nothing".
        name: "entries_that_are_reached_unmapped_do_nothing",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_BufLaserOff(1);GT_LnXY(1,1000,0,10,2);GT_SetLaserCrdMap(0,2);GO Sleep(30);GT_SetHSIOOpt(1);",
        light: &[(30.0, END)],
        power: &[(20.0, 0.0), (40.0, 5.0), (80.0, 5.0)],
        ..NONE
    },
    Rule {
        name: "stop_bit_10_ends_the_follow_and_leaves_the_direct_power",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(20);GT_Stop(1024,0);",
        light: &[(0.0, 55.0)],
        power: &[(19.0, 6.0), (20.0, 5.0), (30.0, 5.0)],
        places: &[(55.0, 1, 500.0)],
        ..NONE
    },
    Rule {
        name: "gus_a_direct_power_ends_the_follow",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_BufLaserPrfCmd(1,2);GT_LnXY(1,1000,0,10,2);GO",
        power: &[(20.0, 6.0), (80.0, 2.0)],
        light: &[(0.0, 110.0)],
        ..NONE
    },
    Rule {
        name: "gus_an_immediate_direct_power_ends_it_too",
        body: "GT_BufLaserPrfFollow(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO Sleep(20);GT_LaserPrfCmd(2);",
        power: &[(19.0, 6.0), (20.0, 2.0), (30.0, 2.0)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "lsr_a_direct_power_adds",
        family: Family::Lsr,
        body: "GT_LaserPrfCmd(1.5);GT_BufLaserFollowRatio(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_BufLaserPrfCmd(1,2);GT_LnXY(1,1000,0,10,2);GT_BufLaserFollowOff(1);GT_LnXY(1,1500,0,10,2);GO",
        power: &[(20.0, 7.5), (80.0, 8.0), (130.0, 2.0)],
        light: &[(0.0, 165.0)],
        ..NONE
    },
    Rule {
        name: "lsr_a_start_power_is_the_direct_power",
        family: Family::Lsr,
        body: "GT_BufLaserFollowMode(1,0,0,0,2.5);GT_BufLaserFollowRatio(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        power: &[(20.0, 8.5)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "lsr_without_a_start_power_the_direct_power_stays",
        family: Family::Lsr,
        body: "GT_LaserPrfCmd(2);GT_BufLaserFollowMode(1,0,0,0);GT_BufLaserFollowRatio(1,0.5,1,9);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        power: &[(20.0, 8.0)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "a_follow_holds_its_bounds",
        body: "GT_BufLaserPrfFollow(1,0.5,1,4);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        // 1 + 0.5·v: 4 from 6 pulse/ms on, at 3 ms.
        power: &[(4.0, 4.0), (20.0, 4.0)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "a_table_gives_the_power_of_a_speed",
        // Between (5, 2) and (15, 8) at 10: 5. Below the first and above the last the border.
        body: "double v[2]={5,15};double p[2]={2,8};GT_SetLaserFollowTable(1,2,v,p,0);GT_LaserPrfCmd(0);GT_BufLaserFollowTable(1,1,0,10);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GT_LnXY(1,1500,0,20,2);GO",
        power: &[(20.0, 5.0), (55.5, 2.0), (80.0, 8.0)],
        light: &[(0.0, 115.0)],
        ..NONE
    },
    Rule {
        name: "excluding_bounds_output_the_lowest_of_the_upper_ones",
        // The sum is 6 and less; distance bounds from 7 to 8, the mode's up to 4.
        body: "long o[4]={0,0,0,0};double s[4]={1000,1000,1000,1000};double r[4]={0,0,0,0};GT_LaserPowerMode(2,4,0);GT_LaserPrfCmd(3);GT_SetLaserDisMode(1,0,o,s);GT_SetLaserDisRatio(r,7,8);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        power: &[(20.0, 4.0)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "distance_adds_to_the_power",
        // 2 V for 1000 pulses from 100 on: at 475 0.75.
        body: "long o[4]={100,0,0,0};double s[4]={1000,1000,1000,1000};double r[4]={2,0,0,0};GT_SetLaserDisMode(1,0,o,s);GT_SetLaserDisRatio(r,0,10);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        power: &[(0.0, 4.8), (50.0, 5.75), (54.75, 5.799_875)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "distance_begins_with_ratios_0",
        body: "long o[4]={100,0,0,0};double s[4]={1000,1000,1000,1000};GT_SetLaserDisMode(1,0,o,s);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        power: &[(0.0, 5.0), (50.0, 5.0)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "gus_the_sum_is_held_in_the_distance_bounds",
        body: "long o[4]={0,0,0,0};double s[4]={100,100,100,100};double r[4]={1,0,0,0};GT_SetLaserDisMode(1,0,o,s);GT_SetLaserDisRatio(r,0,7);GT_BufLaserPrfFollow(1,0.5,1,5);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        // The velocity part is held at 5; 25 pulses add 0.25, 475 add 4.75.
        power: &[(5.0, 5.25), (50.0, 7.0)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "lsr_the_sum_is_held_in_the_follow_bounds",
        family: Family::Lsr,
        body: "long o[4]={0,0,0,0};double s[4]={100,100,100,100};double r[4]={1,0,0,0};GT_LaserPrfCmd(0);GT_SetLaserDisMode(1,0,o,s);GT_SetLaserDisRatio(r);GT_BufLaserFollowRatio(1,0.5,1,7);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        // 1 + 5 + 0.25 at 5 ms, where 10 pulse/ms is reached; 7 from 100 pulses on.
        power: &[(5.0, 6.25), (20.0, 7.0), (50.0, 7.0)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
    Rule {
        name: "a_table_of_one_axis_gives_the_ratio_of_a_position",
        // At 475 of axis 1 the ratio is between 0 at 0 and 2 at 1000: 0.95; times 475/1000.
        body: "long o[4]={0,0,0,0};double s[4]={1000,1000,1000,1000};double r[8]={0,2,0,0,0,0,0,0};long q[8]={0,1000,0,1000,0,1000,0,1000};GT_SetLaserDisMode(1,0,o,s);GT_SetLaserDisTable1D(2,r,q,0,10,NULL);GT_BufLaserOn(1);GT_LnXY(1,500,0,10,2);GO",
        power: &[(50.0, 5.451_25)],
        light: &[(0.0, 55.0)],
        ..NONE
    },
];
