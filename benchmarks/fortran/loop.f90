! Calls a user routine in a loop: what a driver written in Fortran pays for a call.
subroutine loop(calls, address, props, count) bind(C)
  use, intrinsic :: iso_c_binding
  implicit none
  integer(c_int64_t), value :: calls
  type(c_funptr), value :: address
  integer(c_int), value :: count
  real(c_double) :: props(count), stress(6), statev(1), ddsdde(6, 6), zero, none(6), strain(6), time(2), three(3)
  real(c_double) :: matrix(3, 3), pnewdt
  character(80) :: name
  integer(c_int64_t) :: i
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
  pnewdt = 1
  name = "SOIL"
  strain = [1.0d-3, -2.0d-4, 4.0d-4, 6.0d-4, 2.0d-4, -1.0d-4]
  do i = 1, calls
    stress = [-60.0d0, -100.0d0, -55.0d0, 8.0d0, 3.0d0, 4.0d0]
    call called(stress, statev, ddsdde, zero, zero, zero, zero, none, none, zero, none, strain, time, zero, zero, zero, &
                three, three, name, 3, 3, 6, 0, props, count, three, matrix, pnewdt, zero, matrix, matrix, 1, 1, 1, 1, &
                1, 1)
  end do
end subroutine loop
