# Computes delay embedding and correlation dimension of a rattling drive from an Arrow file, with packages of JuliaDynamics.
#
#     atlas trace manifests/quickstart.toml --point load=0.1,speed=628 --skip 1000 --cycles 20000 --samples-per-cycle 1 --out results/trace
#     atlas export results/trace --format arrow
#     julia -e 'import Pkg; Pkg.add(["Arrow", "DelayEmbeddings", "FractalDimensions"])'
#     julia examples/dynamical_systems.jl results/trace/export/trace.arrow
#
# One sample per mesh cycle is the Poincaré map of the drive: deflection and velocity at mesh phase 0. Compare the dimension with
# `kaplan_yorke` in points.parquet, which atlas computes from the exponents if enough of them are requested.
#
# The tests of this repository do not install Julia and do not run this file (docs/known-issues.md).

using Arrow
using DelayEmbeddings
using FractalDimensions

function standardized(values)
    mean = sum(values) / length(values)
    return (values .- mean) ./ sqrt(sum(abs2, values .- mean) / (length(values) - 1))
end

function main(path)
    table = Arrow.Table(path)
    println("columns: ", join(propertynames(table), ", "))
    println("deflection in ", Arrow.getmetadata(table.deflection)["unit"])
    deflection = standardized(collect(Float64, table.deflection))
    velocity = standardized(collect(Float64, table.velocity))

    # The plane of deflection and velocity, and spaces reconstructed from the deflection alone.
    println("correlation dimension of (deflection, velocity): ",
        grassberger_proccaccia_dim(StateSpaceSet(deflection, velocity)))
    for dimension in 2:6
        println("embedded in ", dimension, " dimensions: ",
            grassberger_proccaccia_dim(embed(deflection, dimension, 1)))
    end
end

main(only(ARGS))
