! Elasticity with creep after Norton: the creep strain has the rate 3/2 A q**(m - 1) s; implicit. PROPS: E, nu, A, m.
! STATEV: equivalent creep strain; TIME(2) at the end of the increment, by the routine's own account.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
                dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, &
                dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  implicit none
  character(80) :: cmname
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep(4), kinc
  real(8) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), ddsddt(ntens), drplde(ntens), stran(ntens)
  real(8) :: dstran(ntens), time(2), predef(1), dpred(1), props(nprops), coords(3), drot(3, 3), dfgrd0(3, 3)
  real(8) :: dfgrd1(3, 3), sse, spd, scd, rpl, drpldt, dtime, temp, dtemp, pnewdt, celent
  real(8) :: bulk, g, a, m, p, q, trial, rate, slope, share, s(6), n(6), volume
  integer :: i, j, round

  bulk = props(1)/(3.0d0*(1.0d0 - 2.0d0*props(2)))
  g = props(1)/(2.0d0*(1.0d0 + props(2)))
  a = props(3)
  m = props(4)
  p = sum(stress(1:3))/3.0d0
  volume = sum(dstran(1:3))
  do i = 1, ntens
    s(i) = stress(i) - merge(p, 0.0d0, i <= 3) + 2.0d0*g*merge(dstran(i) - volume/3.0d0, 0.5d0*dstran(i), i <= 3)
  end do
  p = p + bulk*volume
  trial = sqrt(1.5d0*(sum(s(1:3)**2) + 2.0d0*sum(s(4:ntens)**2)))
  ! q + 3 g a dtime q**m = trial, from above: convex, so Newton's method goes down to the root.
  q = trial
  do round = 1, 200
    rate = a*dtime*q**m
    slope = merge(a*dtime*m*q**(m - 1.0d0), 0.0d0, q > 0.0d0)
    share = (q + 3.0d0*g*rate - trial)/(1.0d0 + 3.0d0*g*slope)
    q = q - share
    if (abs(share) <= 1.0d-15*trial) exit
  end do
  rate = a*dtime*q**m
  slope = merge(a*dtime*m*q**(m - 1.0d0), 0.0d0, q > 0.0d0)
  share = 1.0d0
  n = 0.0d0
  if (trial > 0.0d0) then
    share = q/trial
    n(1:ntens) = sqrt(1.5d0)*s(1:ntens)/trial
  end if
  statev(1) = statev(1) + rate
  statev(2) = time(2) + dtime
  ddsdde = 0.0d0
  do i = 1, ntens
    stress(i) = share*s(i) + merge(p, 0.0d0, i <= 3)
    ddsdde(i, i) = merge(2.0d0, 1.0d0, i <= 3)*share*g
  end do
  ddsdde(1:3, 1:3) = ddsdde(1:3, 1:3) + bulk - 2.0d0/3.0d0*share*g
  do j = 1, ntens
    do i = 1, ntens
      ddsdde(i, j) = ddsdde(i, j) + 2.0d0*g*n(i)*n(j)*(1.0d0/(1.0d0 + 3.0d0*g*slope) - share)
    end do
  end do
end subroutine umat
