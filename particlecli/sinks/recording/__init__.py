"""Rerun recordings: written, read back and compared. Nothing outside this package imports Rerun.

What is where in a recording:

    particles/<group>        points with colours and radii, and the numbers `ids` of the particles
    springs/<group>          whole springs as line strips
    frames/<frame>/<frame>   poses of coordinate frames, each below the one it rides on
    planes/<number>          a piece of each plane, and its normal
    plots/<plot>/<name>      time series
    scene, report            the resolved scene, YAML, and the report, JSON, as documents
    files/<number>           data files that the scene reads: name and content

Everything that changes stands on the timelines `frame` and `sim_time`. Numbers and colours of particles are
written when they change, and hold until they change again, which is how Rerun reads them.
"""
