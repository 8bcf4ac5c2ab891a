! A driver of one material point as incrementalDriver has it: drained triaxial compression with a user routine. Equal
! increments of axial strain; the lateral strain of each by Newton's method with DDSDDE until the lateral stress holds.
subroutine driver(tests, steps, address, props, count, state_count, cell, strain_end, q) bind(C)
  use, intrinsic :: iso_c_binding
  implicit none
  integer(c_int64_t), value :: tests
  integer(c_int), value :: steps, count, state_count
  type(c_funptr), value :: address
  real(c_double), value :: cell, strain_end
  real(c_double) :: props(count), q(steps)
  real(c_double) :: stress(6), tried(6), ddsdde(6, 6), zero, none(6), strain(6), total(6), time(2), three(3)
  real(c_double) :: matrix(3, 3), pnewdt, rest
  real(c_double), allocatable :: state(:), kept(:)
  character(80) :: name
  integer(c_int64_t) :: test
  integer :: i, k
  abstract interface
    subroutine routine(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, &
                       temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, &
                       pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
      character(80) :: cmname
      integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc
      real(8) :: stress(*), statev(*), ddsdde(6, *), sse, spd, scd, rpl, ddsddt(*), drplde(*), drpldt, stran(*)
      real(8) :: dstran(*), time(*), dtime, temp, dtemp, predef(*), dpred(*), props(*), coords(*), drot(3, *), pnewdt
      real(8) :: celent, dfgrd0(3, *), dfgrd1(3, *)
    end subroutine routine
  end interface
  procedure(routine), pointer :: called
  call c_f_procpointer(address, called)
  zero = 0
  none = 0
  time = 0
  three = 0
  matrix = 0
  name = "SOIL"
  allocate (state(max(state_count, 1)), kept(max(state_count, 1)))
  do test = 1, tests
    stress = [-cell, -cell, -cell, 0.0d0, 0.0d0, 0.0d0]
    kept = 0
    total = 0
    strain = 0
    do i = 1, steps
      strain(2) = -strain_end/steps
      do k = 1, 20
        tried = stress
        state = kept
        pnewdt = 1
        call called(tried, state, ddsdde, zero, zero, zero, zero, none, none, zero, total, strain, time, zero, zero, &
                    zero, three, three, name, 3, 3, 6, state_count, props, count, three, matrix, pnewdt, zero, matrix, &
                    matrix, 1, 1, 1, 1, 1, 1)
        rest = tried(1) + cell
        if (abs(rest) <= 1.0d-9*cell) exit
        strain(1) = strain(1) - rest/(ddsdde(1, 1) + ddsdde(1, 3))
        strain(3) = strain(1)
      end do
      stress = tried
      kept = state
      total = total + strain
      q(i) = stress(1) - stress(2)
    end do
  end do
end subroutine driver
